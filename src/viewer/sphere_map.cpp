// Directions on the maps of the guide, and where they lead in the image.
#include "viewer/sphere_map.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {
constexpr float kTwoPi = 6.28318530718f;
}

glm::vec3 directionAt(glm::vec2 place) {
    const float azimuth = kTwoPi * place.x, z = 1 - 2 * place.y, r = std::sqrt(std::max(0.f, 1 - z * z));
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

glm::vec2 placeOfDirection(glm::vec3 direction) {
    const float turn = std::atan2(direction.y, direction.x) / kTwoPi;
    return {turn < 0 ? turn + 1 : turn, 0.5f * (1 - direction.z)};
}

std::optional<glm::vec2> brightest(const Image& map) {
    const auto most = std::max_element(map.values.begin(), map.values.end());
    if (most == map.values.end() || !(*most > 0))
        return std::nullopt;
    const int at = int(most - map.values.begin()) / map.channels;
    const int row = at / map.width, column = at % map.width;
    return glm::vec2((float(column) + 0.5f) / float(map.width), (float(row) + 0.5f) / float(map.height));
}

std::optional<glm::vec2> project(const Camera& camera, glm::vec3 point, int width, int height) {
    const glm::vec3 local = glm::vec3(glm::inverse(poseOf(camera)) * glm::vec4(point, 1));
    const float aspect = float(width) / float(height);
    glm::vec2 plane; // up to 1 at the upper edge, up to the aspect ratio at the right one
    if (camera.orthographic) {
        plane = glm::vec2(local) / camera.ymag;
    } else {
        if (local.z > -1e-6f)
            return std::nullopt;
        plane = glm::vec2(local) / (-local.z * std::tan(0.5f * camera.yfov));
    }
    return glm::vec2((0.5f + 0.5f * plane.x / aspect) * float(width), (0.5f - 0.5f * plane.y) * float(height));
}

} // namespace cmpg::viewer

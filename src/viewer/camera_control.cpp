// Moving a camera: around a point, sideways, towards a point, and flying.
#include "viewer/camera_control.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

namespace cmpg::viewer {
namespace {

constexpr glm::vec3 kUp{0, 1, 0};
constexpr float kSteepest = 1.55f; // radians from level; the horizon is undefined at pi / 2

glm::vec3 axis(const Camera& camera, int column) {
    return glm::normalize(glm::vec3(poseOf(camera)[column]));
}

void moveTo(Camera& camera, glm::vec3 eye) {
    std::copy_n(glm::value_ptr(eye), 3, camera.toWorld.begin() + 12);
}

} // namespace

glm::mat4 poseOf(const Camera& camera) {
    return glm::make_mat4(camera.toWorld.data());
}

void setPose(Camera& camera, const glm::mat4& pose) {
    std::copy_n(glm::value_ptr(pose), camera.toWorld.size(), camera.toWorld.begin());
}

glm::vec3 eyeOf(const Camera& camera) {
    return glm::vec3(poseOf(camera)[3]);
}

glm::vec3 forwardOf(const Camera& camera) {
    return -axis(camera, 2);
}

glm::vec3 pivotAhead(const Camera& camera, glm::vec3 lower, glm::vec3 upper) {
    const glm::vec3 middle = 0.5f * (lower + upper);
    const float size = std::max(glm::length(upper - lower), 1e-6f);
    return eyeOf(camera) + forwardOf(camera) * std::max(glm::dot(middle - eyeOf(camera), forwardOf(camera)), 0.05f * size);
}

void orbit(Camera& camera, glm::vec3 pivot, float yaw, float pitch) {
    const float level = std::asin(std::clamp(forwardOf(camera).y, -1.f, 1.f));
    // A camera that already looks steeper, as files may hold, is not forced back at the first touch.
    const float steepest = std::max(kSteepest, std::abs(level));
    pitch = std::clamp(level + pitch, -steepest, steepest) - level;
    const glm::vec3 right = axis(camera, 0);
    const glm::mat4 turn = glm::rotate(glm::mat4(1), yaw, kUp) * glm::rotate(glm::mat4(1), pitch, right);
    setPose(camera, glm::translate(glm::mat4(1), pivot) * turn * glm::translate(glm::mat4(1), -pivot) * poseOf(camera));
}

void slide(Camera& camera, glm::vec3 distance) {
    const glm::vec3 by = axis(camera, 0) * distance.x + axis(camera, 1) * distance.y + forwardOf(camera) * distance.z;
    moveTo(camera, eyeOf(camera) + by);
}

void approach(Camera& camera, glm::vec3 pivot, float factor) {
    const glm::vec3 eye = pivot + (eyeOf(camera) - pivot) * factor;
    moveTo(camera, eye);
    camera.ymag *= factor;
}

} // namespace cmpg::viewer

// In the image, an arrow from the point that was clicked to where the guide sends rays.
#include "viewer/guide_arrow.h"

#include "viewer/sphere_map.h"
#include "viewer/theme.h"

#include <cmath>

namespace cmpg::viewer {
namespace {

// The camera of the click: the one that sees its point at its pixel. None after the camera was moved away in the meantime.
const Camera* cameraOf(const LiveState& state, int width, int height) {
    const LivePick& pick = *state.pick;
    const auto sees = [&](const Camera& camera) {
        const auto at = project(camera, pick.position, width, height);
        return at && glm::length(*at - glm::vec2(float(pick.x) + 0.5f, float(pick.y) + 0.5f)) < 1.5f;
    };
    if (state.settings.mode != LiveMode::Optimize)
        return &state.settings.camera; // the arrow moves with it
    for (const Camera& camera : state.scene->cameras)
        if (sees(camera))
            return &camera;
    return nullptr;
}

} // namespace

void drawGuideArrow(const Desk& desk, const Rectangle& place) {
    const LiveState& state = *desk.state;
    const auto& pick = state.pick;
    if (!desk.inspector || !pick || !pick->hit || !state.scene)
        return;
    const glm::ivec2 size = desk.imageSize();
    const Camera* const camera = cameraOf(state, size.x, size.y);
    const auto onScreen = [&](glm::vec2 pixel) {
        return ImVec2(place.x + pixel.x / float(size.x) * place.width, place.y + pixel.y / float(size.y) * place.height);
    };
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float font = ImGui::GetFontSize();
    const auto start = camera ? project(*camera, pick->position, size.x, size.y) : glm::vec2(float(pick->x) + 0.5f, float(pick->y) + 0.5f);
    if (!start)
        return;
    const ImVec2 from = onScreen(*start);
    draw.AddCircle(from, 0.4f * font + 1, packed({0, 0, 0, 0.7f}), 0, 3);
    draw.AddCircle(from, 0.4f * font, packed(kAccent), 0, 2);
    std::optional<glm::vec3> direction = desk.direction;
    if (!direction && pick->maps[3])
        if (const auto peak = brightest(*pick->maps[3]))
            direction = directionAt(*peak);
    if (!camera || !direction)
        return;
    // As long as half the scene's box, shorter where it would end outside the image or behind the camera.
    float length = 0.5f * glm::length(state.scene->upper - state.scene->lower);
    std::optional<glm::vec2> end;
    for (int i = 0; i < 30; ++i, length *= 0.85f) {
        end = project(*camera, pick->position + *direction * length, size.x, size.y);
        if (end && end->x > 0 && end->y > 0 && end->x < float(size.x) && end->y < float(size.y))
            break;
    }
    if (!end)
        return;
    const ImVec2 to = onScreen(*end);
    const glm::vec2 along(to.x - from.x, to.y - from.y);
    const float distance = glm::length(along);
    if (distance < font)
        return; // it points along the view
    const glm::vec2 unit = along / distance, side(-unit.y, unit.x);
    const auto point = [&](float forward, float across) {
        const glm::vec2 p = glm::vec2(to.x, to.y) + unit * forward + side * across;
        return ImVec2(p.x, p.y);
    };
    draw.AddLine({from.x + unit.x * 0.4f * font, from.y + unit.y * 0.4f * font}, to, packed({0, 0, 0, 0.6f}), 4.5f);
    draw.AddLine({from.x + unit.x * 0.4f * font, from.y + unit.y * 0.4f * font}, to, packed(kAccent), 2.2f);
    draw.AddTriangleFilled(point(0.3f * font, 0), point(-0.6f * font, 0.35f * font), point(-0.6f * font, -0.35f * font), packed(kAccent));
}

} // namespace cmpg::viewer

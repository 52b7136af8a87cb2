// The line at the bottom: what is under the cursor, or what is going on.
#include "viewer/status_line.h"

#include "viewer/picture_text.h"
#include "viewer/theme.h"
#include "viewer/widgets.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {

std::string hoverText(const Desk& desk) {
    const Hover& hover = *desk.hover;
    const auto& image = desk.state->picture(hover.picture);
    if (!image)
        return "";
    const bool texel = groupOf(hover.picture) == Group::Parameter;
    return titleOf(*desk.state, hover.picture) + "   " + (texel ? "texel " : "pixel ") + std::to_string(hover.pixel.x) + ", " +
           std::to_string(hover.pixel.y) + "   " + valueText(*image, hover.pixel, hover.picture);
}

} // namespace

float statusHeight() {
    return std::round(1.6f * ImGui::GetFontSize());
}

void drawStatusLine(const Desk& desk, const Rectangle& area) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float y = std::round(area.y + 0.5f * (area.height - ImGui::GetFontSize()));
    const LiveState& state = *desk.state;
    std::string right = state.device;
    if (state.samplesPerSecond > 0) {
        char speed[64];
        std::snprintf(speed, sizeof speed, "%.2g M samples/s   ", state.samplesPerSecond * 1e-6);
        right = speed + right;
    }
    // The last message stays: in the place of the hint, or at the right of what is under the cursor. A file's name is its end.
    std::string left = desk.hover ? hoverText(desk) : desk.saved;
    const bool hint = left.empty();
    if (hint)
        left = "F1: keys and gestures     click: the guide at that point     drop: a scene, a target or both";
    const bool told = desk.hover && !desk.saved.empty();
    const float gap = ImGui::GetFontSize();
    left = desk.hover || hint ? shortened(left, area.width) : shortenedAtFront(left, area.width);
    const float leftWidth = ImGui::CalcTextSize(left.c_str()).x;
    draw.AddText({area.x, y}, packed(desk.hover ? kInk : hint ? kDim : kAccent), left.c_str());
    if (told)
        right = shortenedAtFront(desk.saved, area.width - leftWidth - gap);
    const float width = ImGui::CalcTextSize(right.c_str()).x;
    if (leftWidth + width + gap <= area.width)
        draw.AddText({area.right() - width, y}, packed(told ? kAccent : kDim), right.c_str());
}

void drawNotice(const Desk& desk, const Rectangle& area) {
    const LiveState& state = *desk.state;
    if (state.notice.empty())
        return;
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float font = ImGui::GetFontSize();
    const float wrap = std::max(4 * font, area.width - 3.4f * font);
    const ImVec2 size = ImGui::CalcTextSize(state.notice.c_str(), nullptr, false, wrap);
    const float width = size.x + 3.4f * font, height = size.y + font;
    const ImVec2 corner(std::round(area.x + 0.5f * (area.width - width)), std::round(area.y + 0.35f * (area.height - height)));
    draw.AddRectFilled(corner, {corner.x + width, corner.y + height}, packed({0.08f, 0.08f, 0.09f, 0.92f}), 4);
    draw.AddRect(corner, {corner.x + width, corner.y + height}, packed(kAccent, 0.6f), 4);
    const ImVec2 middle(corner.x + 1.2f * font, corner.y + 0.5f * height);
    if (state.busy) {
        const float turn = float(std::fmod(ImGui::GetTime(), 1.0)) * 6.2832f;
        draw.PathArcTo(middle, 0.5f * font, turn, turn + 4.2f, 16);
        draw.PathStroke(packed(kAccent), 0, 2);
    } else {
        draw.AddCircleFilled(middle, 0.25f * font, packed(kAccent));
    }
    draw.AddText(nullptr, 0, {corner.x + 2.2f * font, corner.y + 0.5f * (height - size.y)}, packed(kInk), state.notice.c_str(), nullptr, wrap + 1);
}

} // namespace cmpg::viewer

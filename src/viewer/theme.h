// How the interface looks: fonts and colours, for the scale of the display.
#pragma once

#include <imgui.h>

namespace cmpg::viewer {

// Fonts and sizes for this scale; before the first frame and whenever it changes.
void applyTheme(float scale);

// Colours beside those of Dear ImGui's style.
inline const ImVec4 kInk{0.90f, 0.90f, 0.91f, 1}, kDim{0.60f, 0.60f, 0.63f, 1}, kAccent{0.98f, 0.66f, 0.31f, 1}, kAlarm{1.00f, 0.45f, 0.40f, 1};

inline ImU32 packed(const ImVec4& color, float opacity = 1) {
    return ImGui::ColorConvertFloat4ToU32({color.x, color.y, color.z, color.w * opacity});
}

} // namespace cmpg::viewer

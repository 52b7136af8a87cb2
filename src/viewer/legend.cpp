// Colour bars with their scale, drawn with Dear ImGui.
#include "viewer/legend.h"

#include "imaging/display_image.h"
#include "imaging/signed_colors.h"
#include "viewer/theme.h"

#include <algorithm>

namespace cmpg::viewer {
namespace {

ImU32 encoded(const Color& linear) {
    return packed({srgbEncode(linear[0]), srgbEncode(linear[1]), srgbEncode(linear[2]), 1});
}

} // namespace

std::string shortNumber(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

float legendHeight() {
    return std::round(1.4f * ImGui::GetFontSize());
}

void drawLegend(const PictureLook& look, const Rectangle& strip) {
    if (!(look.scale > 0))
        return;
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float font = ImGui::GetFontSize();
    char low[32] = "0", high[32];
    if (look.isSigned)
        std::snprintf(low, sizeof low, "%.3g", -look.scale);
    std::snprintf(high, sizeof high, look.isSigned ? "%+.3g" : "%.3g", look.scale);
    const float lowWidth = ImGui::CalcTextSize(low).x, highWidth = ImGui::CalcTextSize(high).x;
    // One line, centred: low, bar, high.
    const float gap = 0.4f * font, bar = std::min(16 * font, strip.width - lowWidth - highWidth - 2 * gap);
    if (bar < 2 * font)
        return;
    const float left = std::round(strip.x + 0.5f * (strip.width - bar - lowWidth - highWidth - 2 * gap));
    const float top = std::round(strip.y + 0.5f * (strip.height - font));
    draw.AddText({left, top}, packed(kDim), low);
    const float x = left + lowWidth + gap;
    constexpr int kPieces = 48;
    const auto colorAt = [&](double t) { return encoded(look.isSigned ? signedColor(2 * t - 1) : heatColor(t)); };
    for (int i = 0; i < kPieces; ++i) {
        const ImU32 a = colorAt(double(i) / kPieces), b = colorAt(double(i + 1) / kPieces);
        draw.AddRectFilledMultiColor({x + bar * float(i) / kPieces, top + 0.2f * font}, {x + bar * float(i + 1) / kPieces, top + 0.85f * font}, a, b, b, a);
    }
    draw.AddText({x + bar + gap, top}, packed(kDim), high);
}

} // namespace cmpg::viewer

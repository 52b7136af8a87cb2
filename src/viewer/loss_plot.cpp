// The loss over the steps, drawn with Dear ImGui.
#include "viewer/loss_plot.h"

#include "imaging/loss_curve.h"
#include "viewer/legend.h"
#include "viewer/theme.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {

void drawLossPlot(const Rectangle& area, std::span<const double> loss) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float font = ImGui::GetFontSize();
    // Its last value stands beside the title: in the column of the ticks it would be taken for one.
    draw.AddText({area.x, area.y}, packed(kInk), "loss");
    if (!loss.empty())
        draw.AddText({area.x + ImGui::CalcTextSize("loss").x + 0.8f * font, area.y}, packed(kAccent), shortNumber(loss.back()).c_str());
    const float left = area.x + 4.2f * font, right = area.right() - 0.6f * font;
    const float top = area.y + 1.8f * font, bottom = area.bottom() - 1.5f * font;
    if (right - left < 2 * font || bottom - top < font)
        return;
    draw.AddRectFilled({left, top}, {right, bottom}, packed({0.085f, 0.085f, 0.09f, 1}));
    if (loss.empty()) {
        draw.AddText({left + 0.8f * font, 0.5f * (top + bottom - font)}, packed(kDim), "no step yet");
        return;
    }
    const CurveAxes axes = axesOf(loss);
    const auto x = [&](double step) { return left + float(axes.across(step)) * (right - left); };
    const auto y = [&](double value) { return bottom - float(axes.up(value)) * (bottom - top); };
    float free = bottom + font; // labels keep apart
    for (const double tick : axes.ticks) {
        const float at = std::round(y(tick));
        draw.AddLine({left, at}, {right, at}, packed(kDim, 0.25f));
        if (free - at < 1.1f * font)
            continue;
        const std::string label = shortNumber(tick);
        draw.AddText({left - ImGui::CalcTextSize(label.c_str()).x - 0.3f * font, at - 0.5f * font}, packed(kDim), label.c_str());
        free = at;
    }
    std::vector<ImVec2> points;
    // More steps than pixels: the extremes would hide each other anyway.
    const std::size_t stride = std::max<std::size_t>(1, loss.size() / std::size_t(std::max(1.f, 2 * (right - left))));
    for (std::size_t i = 0; i < loss.size(); i += stride)
        if (std::isfinite(loss[i]))
            points.push_back({x(double(i)), y(loss[i])});
    draw.AddPolyline(points.data(), int(points.size()), packed(kAccent), 0, std::max(1.5f, 0.1f * font));
    if (points.size() == 1)
        draw.AddCircleFilled(points[0], 0.2f * font, packed(kAccent));
    draw.AddText({left, bottom + 0.2f * font}, packed(kDim), "step 1");
    const std::string last = std::to_string(loss.size());
    if (loss.size() > 1)
        draw.AddText({right - ImGui::CalcTextSize(last.c_str()).x, bottom + 0.2f * font}, packed(kDim), last.c_str());
}

} // namespace cmpg::viewer

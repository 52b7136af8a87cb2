// Errors over time, both axes logarithmic.
#include "lab/error_plot.h"

#include "imaging/number_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

constexpr double kWidth = 760, kHeight = 420, kLeft = 74, kRight = 560, kTop = 40, kBottom = 366;

} // namespace

std::string curveColor(std::size_t index) {
    constexpr const char* kColors[] = {"#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f"};
    return kColors[index % std::size(kColors)];
}

void drawLogAxes(Drawing& drawing, const LogAxis& across, const LogAxis& up, const std::string& below, const std::string& beside) {
    using Anchor = Drawing::Anchor;
    const char *const grid = "#e2e2e2", *const frame = "#444444";
    for (const double tick : ticksOf(up)) {
        drawing.line(across.from, up.place(tick), across.to, up.place(tick), grid);
        drawing.text(across.from - 6, up.place(tick) + 4, threeDigits(tick), Anchor::End);
    }
    for (const double tick : ticksOf(across)) {
        drawing.line(across.place(tick), up.to, across.place(tick), up.from, grid);
        drawing.text(across.place(tick), up.from + 17, threeDigits(tick), Anchor::Middle);
    }
    drawing.box(across.from, up.to, across.to, up.from, frame);
    drawing.text((across.from + across.to) / 2, up.from + 38, below, Anchor::Middle);
    drawing.upwards(16, (up.from + up.to) / 2, beside);
}

void ErrorPlot::draw(Drawing& drawing) const {
    PlotBounds bounds;
    for (const ErrorCurve& curve : curves)
        for (const auto& [seconds, error] : curve.points)
            bounds.add(seconds, error);
    const bool hasFloor = floor && *floor > 0 && std::isfinite(*floor);
    if (hasFloor && !bounds.empty())
        bounds.y0 = std::min(bounds.y0, std::max(*floor, bounds.y0 / 30)); // far below the curves it says nothing
    const LogAxis across = bounds.across(kLeft, kRight), up = bounds.up(kBottom, kTop);

    drawing.text(kLeft, 22, title, Drawing::Anchor::Start, "#000000", 15);
    drawLogAxes(drawing, across, up, "seconds", vertical);
    if (hasFloor && up.place(*floor) <= kBottom) {
        drawing.line(kLeft, up.place(*floor), kRight, up.place(*floor), "#777777", 1, true);
        drawing.text(kLeft + 6, up.place(*floor) - 5, floorName, Drawing::Anchor::Start, "#666666");
    }
    for (std::size_t i = 0; i < curves.size(); ++i) {
        const std::string color = curveColor(i);
        std::vector<Drawing::Point> points;
        for (const auto& [seconds, error] : curves[i].points)
            if (drawable(seconds, error))
                points.emplace_back(across.place(seconds), up.place(error));
        drawing.path(points, color, 2);
        constexpr std::size_t kMostMarks = 40; // a step each would be a sausage
        if (points.size() <= kMostMarks)
            for (const auto& [x, y] : points)
                drawing.circle(x, y, 2.6, color);
        const double y = kTop + 14 + 20 * double(i);
        drawing.line(kRight + 14, y, kRight + 34, y, color, 3);
        drawing.text(kRight + 40, y + 4, curves[i].name);
    }
}

std::string ErrorPlot::svg() const {
    Drawing drawing(Drawing::Target::Svg, kWidth, kHeight, title);
    draw(drawing);
    return drawing.svg();
}

Image ErrorPlot::picture() const {
    Drawing drawing(Drawing::Target::Picture, kWidth, kHeight);
    draw(drawing);
    return drawing.picture();
}

} // namespace cmpg

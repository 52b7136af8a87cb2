// Errors over time, both axes logarithmic, as an SVG.
#include "lab/error_plot.h"

#include "imaging/html.h"
#include "imaging/plot_axes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

constexpr double kWidth = 760, kHeight = 420, kLeft = 74, kRight = 560, kTop = 40, kBottom = 366;

std::string format(const char* text, auto... values) {
    char buffer[400];
    std::snprintf(buffer, sizeof buffer, text, values...);
    return buffer;
}

} // namespace

std::string svgFile(std::string svg) {
    constexpr std::size_t kTag = 4; // "<svg"
    return svg.insert(kTag, " xmlns=\"http://www.w3.org/2000/svg\"");
}

std::string curveColor(std::size_t index) {
    constexpr const char* kColors[] = {"#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f"};
    return kColors[index % std::size(kColors)];
}

std::string ErrorPlot::svg() const {
    PlotBounds bounds;
    for (const ErrorCurve& curve : curves)
        for (const auto& [seconds, error] : curve.points)
            bounds.add(seconds, error);
    const bool hasFloor = floor && *floor > 0 && std::isfinite(*floor);
    if (hasFloor && !bounds.empty())
        bounds.y0 = std::min(bounds.y0, std::max(*floor, bounds.y0 / 30)); // far below the curves it says nothing
    const LogAxis across = bounds.across(kLeft, kRight), up = bounds.up(kBottom, kTop);

    std::string svg = format("<svg viewBox=\"0 0 %g %g\" font-family=\"sans-serif\" font-size=\"12\" "
                             "role=\"img\">\n<rect width=\"%g\" height=\"%g\" fill=\"white\"/>\n",
                             kWidth, kHeight, kWidth, kHeight);
    svg += format("<text x=\"%g\" y=\"22\" font-size=\"15\">", kLeft) + escapeHtml(title) + "</text>\n";
    for (const double tick : ticksOf(up)) {
        svg += format("<line x1=\"%g\" y1=\"%.1f\" x2=\"%g\" y2=\"%.1f\" stroke=\"#e2e2e2\"/>", kLeft, up.place(tick), kRight, up.place(tick));
        svg += format("<text x=\"%g\" y=\"%.1f\" text-anchor=\"end\">%.3g</text>\n", kLeft - 6, up.place(tick) + 4, tick);
    }
    for (const double tick : ticksOf(across)) {
        svg += format("<line x1=\"%.1f\" y1=\"%g\" x2=\"%.1f\" y2=\"%g\" stroke=\"#e2e2e2\"/>", across.place(tick), kTop, across.place(tick),
                      kBottom);
        svg += format("<text x=\"%.1f\" y=\"%g\" text-anchor=\"middle\">%.3g</text>\n", across.place(tick), kBottom + 17, tick);
    }
    svg += format("<rect x=\"%g\" y=\"%g\" width=\"%g\" height=\"%g\" fill=\"none\" stroke=\"#444\"/>\n", kLeft, kTop, kRight - kLeft,
                  kBottom - kTop);
    svg += format("<text x=\"%g\" y=\"%g\" text-anchor=\"middle\">seconds</text>\n", (kLeft + kRight) / 2, kBottom + 38);
    svg += format("<text transform=\"translate(16 %g) rotate(-90)\" text-anchor=\"middle\">", (kTop + kBottom) / 2) + escapeHtml(vertical) +
           "</text>\n";
    if (hasFloor && up.place(*floor) <= kBottom) {
        svg += format("<line x1=\"%g\" y1=\"%.1f\" x2=\"%g\" y2=\"%.1f\" stroke=\"#777\" stroke-dasharray=\"5 4\"/>", kLeft, up.place(*floor),
                      kRight, up.place(*floor));
        svg += format("<text x=\"%g\" y=\"%.1f\" fill=\"#666\">", kLeft + 6, up.place(*floor) - 5) + escapeHtml(floorName) + "</text>\n";
    }
    for (std::size_t i = 0; i < curves.size(); ++i) {
        const std::string color = curveColor(i);
        std::string path, marks;
        std::size_t count = 0;
        for (const auto& point : curves[i].points) {
            if (!drawable(point.first, point.second))
                continue;
            const double x = across.place(point.first), y = up.place(point.second);
            path += format("%c%.1f %.1f", path.empty() ? 'M' : 'L', x, y);
            marks += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.6\"/>", x, y);
            ++count;
        }
        if (!path.empty())
            svg += "<path fill=\"none\" stroke-width=\"2\" stroke-linejoin=\"round\" stroke=\"" + color + "\" d=\"" + path + "\"/>\n";
        constexpr std::size_t kMostMarks = 40; // a step each would be a sausage
        if (count <= kMostMarks)
            svg += "<g fill=\"" + color + "\">" + marks + "</g>\n";
        const double y = kTop + 14 + 20 * double(i);
        svg += format("<line x1=\"%g\" y1=\"%g\" x2=\"%g\" y2=\"%g\" stroke-width=\"3\" stroke=\"", kRight + 14, y, kRight + 34, y) + color +
               format("\"/><text x=\"%g\" y=\"%g\">", kRight + 40, y + 4) + escapeHtml(curves[i].name) + "</text>\n";
    }
    return svg + "</svg>\n";
}

} // namespace cmpg

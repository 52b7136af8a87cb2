// Speed against accuracy: a point per setting, both axes logarithmic, the frontier as a line; as an SVG and as a picture.
#include "lab/pareto_plot.h"

#include "lab/error_plot.h"

#include <algorithm>

namespace cmpg {
namespace {

constexpr double kParetoWidth = 1160, kParetoHeight = 560, kParetoLeft = 76, kParetoRight = 620, kParetoTop = 44, kParetoBottom = 500, kParetoRow = 12.5;

bool shown(const ParetoPoint& p) { return drawable(p.seconds, p.error); }

void draw(const ParetoPlot& plot, Drawing& drawing) {
    using Anchor = Drawing::Anchor;
    const std::string black = "#000000", dark = "#444444", line = "#9a9a9a";
    PlotBounds bounds;
    for (const ParetoPoint& p : plot.points)
        bounds.add(p.seconds, p.error);
    const LogAxis across = bounds.across(kParetoLeft, kParetoRight), up = bounds.up(kParetoBottom, kParetoTop);
    drawing.text(kParetoLeft, 20, plot.title, Anchor::Start, black, 14);
    drawLogAxes(drawing, across, up, plot.across, plot.up);
    for (std::size_t i = 1; i < plot.frontier.size(); ++i) {
        const ParetoPoint &a = plot.points[plot.frontier[i - 1]], &b = plot.points[plot.frontier[i]];
        if (shown(a) && shown(b))
            drawing.line(across.place(a.seconds), up.place(a.error), across.place(b.seconds), up.place(b.error), line, 2);
    }
    double row = kParetoTop + 4;
    for (std::size_t i = 0; i < plot.points.size(); ++i) {
        const ParetoPoint& p = plot.points[i];
        if (!shown(p))
            continue;
        const std::string color = curveColor(p.group), label = std::to_string(i);
        const double x = across.place(p.seconds), y = up.place(p.error);
        drawing.circle(x, y, i == 0 ? 6 : 4, color, !p.biased);
        drawing.text(x + 7, y - 4, label, Anchor::Start, color);
        drawing.circle(kParetoRight + 18, row - 4, 4, color, !p.biased);
        const bool edge = std::find(plot.frontier.begin(), plot.frontier.end(), i) != plot.frontier.end();
        drawing.text(kParetoRight + 28, row, label + "  " + p.name + (edge ? "  *" : ""), Anchor::Start, edge ? black : dark);
        row += kParetoRow;
    }
    drawing.text(kParetoRight + 14, 20, "* on the frontier   hollow: biased", Anchor::Start, dark);
}

} // namespace

std::string ParetoPlot::svg() const {
    Drawing drawing(Drawing::Target::Svg, kParetoWidth, kParetoHeight, title);
    draw(*this, drawing);
    return drawing.svg();
}

Image ParetoPlot::png() const {
    Drawing drawing(Drawing::Target::Picture, kParetoWidth, kParetoHeight);
    draw(*this, drawing);
    return drawing.picture();
}

} // namespace cmpg

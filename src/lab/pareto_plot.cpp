// Speed against accuracy: a point per setting, both axes logarithmic, the frontier as a line; as an SVG and as a picture.
#include "lab/pareto_plot.h"

#include "imaging/html.h"
#include "imaging/plot_axes.h"
#include "imaging/png_canvas.h"
#include "lab/error_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace cmpg {
namespace {

constexpr double kWidth = 1160, kHeight = 560, kLeft = 76, kRight = 620, kTop = 44, kBottom = 500, kRow = 12.5;

// What a plot is drawn with. Colours are "#rrggbb".
class Surface {
  public:
    enum class Anchor { Start, Middle, End };
    virtual ~Surface() = default;
    virtual void line(double x0, double y0, double x1, double y1, const std::string& color, double width) = 0;
    virtual void circle(double x, double y, double radius, const std::string& color, bool filled) = 0;
    virtual void text(double x, double baseline, const std::string& text, Anchor anchor, const std::string& color) = 0;
    virtual void upwards(double x, double middle, const std::string& text) = 0;
};

class SvgSurface final : public Surface {
  public:
    void line(double x0, double y0, double x1, double y1, const std::string& color, double width) override {
        add("<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" stroke=\"%s\" stroke-width=\"%g\"/>\n", x0, y0, x1, y1, color.c_str(), width);
    }
    void circle(double x, double y, double radius, const std::string& color, bool filled) override {
        add("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%g\" fill=\"%s\" stroke=\"%s\" stroke-width=\"1.6\"/>\n", x, y, radius, filled ? color.c_str() : "white",
            color.c_str());
    }
    void text(double x, double baseline, const std::string& text, Anchor anchor, const std::string& color) override {
        const char* kAnchors[] = {"start", "middle", "end"};
        add("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" fill=\"%s\">", x, baseline, kAnchors[int(anchor)], color.c_str());
        body_ += escapeHtml(text) + "</text>\n";
    }
    void upwards(double x, double middle, const std::string& text) override {
        add("<text transform=\"translate(%g %g) rotate(-90)\" text-anchor=\"middle\">", x, middle);
        body_ += escapeHtml(text) + "</text>\n";
    }
    std::string done() const {
        char head[200];
        std::snprintf(head, sizeof head,
                      "<svg viewBox=\"0 0 %g %g\" font-family=\"sans-serif\" font-size=\"12\" role=\"img\">\n<rect width=\"%g\" height=\"%g\" fill=\"white\"/>\n",
                      kWidth, kHeight, kWidth, kHeight);
        return head + body_ + "</svg>\n";
    }

  private:
    void add(const char* format, auto... values) {
        char buffer[400];
        std::snprintf(buffer, sizeof buffer, format, values...);
        body_ += buffer;
    }
    std::string body_;
};

class CanvasSurface final : public Surface {
  public:
    CanvasSurface() : canvas_(int(kWidth), int(kHeight)) {}
    void line(double x0, double y0, double x1, double y1, const std::string& color, double width) override {
        canvas_.line(x0, y0, x1, y1, parse(color), int(std::lround(width)));
    }
    void circle(double x, double y, double radius, const std::string& color, bool filled) override {
        const int reach = int(radius) + 1;
        for (int j = -reach; j <= reach; ++j)
            for (int i = -reach; i <= reach; ++i)
                if (const double d = std::hypot(i, j); d <= radius)
                    canvas_.set(int(std::lround(x)) + i, int(std::lround(y)) + j, filled || d > radius - 1.6 ? parse(color) : kWhite);
    }
    void text(double x, double baseline, const std::string& text, Anchor anchor, const std::string& color) override {
        const int width = Canvas::textWidth(text);
        canvas_.text(int(x) - (anchor == Anchor::Start ? 0 : anchor == Anchor::End ? width : width / 2), int(baseline) - Canvas::textHeight(), text, parse(color));
    }
    void upwards(double, double, const std::string& text) override { canvas_.text(8, int(kTop) - 16, text); } // above its axis instead
    const Image& image() const { return canvas_.image(); }

  private:
    static Color parse(const std::string& color) {
        const long rgb = std::strtol(color.c_str() + 1, nullptr, 16);
        return displayColor(int(rgb >> 16), int(rgb >> 8 & 255), int(rgb & 255));
    }
    Canvas canvas_;
};

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

bool shown(const ParetoPoint& p) { return drawable(p.seconds, p.error); }

void draw(const ParetoPlot& plot, Surface& surface) {
    using Anchor = Surface::Anchor;
    const std::string black = "#000000", grey = "#e2e2e2", dark = "#444444", line = "#9a9a9a";
    PlotBounds bounds;
    for (const ParetoPoint& p : plot.points)
        bounds.add(p.seconds, p.error);
    const LogAxis across = bounds.across(kLeft, kRight), up = bounds.up(kBottom, kTop);
    surface.text(kLeft, 20, plot.title, Anchor::Start, black);
    for (const double tick : ticksOf(up)) {
        surface.line(kLeft, up.place(tick), kRight, up.place(tick), grey, 1);
        surface.text(kLeft - 6, up.place(tick) + 4, number(tick), Anchor::End, black);
    }
    for (const double tick : ticksOf(across)) {
        surface.line(across.place(tick), kTop, across.place(tick), kBottom, grey, 1);
        surface.text(across.place(tick), kBottom + 17, number(tick), Anchor::Middle, black);
    }
    surface.line(kLeft, kTop, kRight, kTop, dark, 1);
    surface.line(kLeft, kBottom, kRight, kBottom, dark, 1);
    surface.line(kLeft, kTop, kLeft, kBottom, dark, 1);
    surface.line(kRight, kTop, kRight, kBottom, dark, 1);
    surface.text((kLeft + kRight) / 2, kBottom + 38, plot.across, Anchor::Middle, black);
    surface.upwards(16, (kTop + kBottom) / 2, plot.up);
    for (std::size_t i = 1; i < plot.frontier.size(); ++i) {
        const ParetoPoint &a = plot.points[plot.frontier[i - 1]], &b = plot.points[plot.frontier[i]];
        if (shown(a) && shown(b))
            surface.line(across.place(a.seconds), up.place(a.error), across.place(b.seconds), up.place(b.error), line, 2);
    }
    double row = kTop + 4;
    for (std::size_t i = 0; i < plot.points.size(); ++i) {
        const ParetoPoint& p = plot.points[i];
        if (!shown(p))
            continue;
        const std::string color = curveColor(p.group), label = std::to_string(i);
        const double x = across.place(p.seconds), y = up.place(p.error);
        surface.circle(x, y, i == 0 ? 6 : 4, color, !p.biased);
        surface.text(x + 7, y - 4, label, Anchor::Start, color);
        surface.circle(kRight + 18, row - 4, 4, color, !p.biased);
        const bool edge = std::find(plot.frontier.begin(), plot.frontier.end(), i) != plot.frontier.end();
        surface.text(kRight + 28, row, label + "  " + p.name + (edge ? "  *" : ""), Anchor::Start, edge ? black : dark);
        row += kRow;
    }
    surface.text(kRight + 14, 20, "* on the frontier   hollow: biased", Anchor::Start, dark);
}

} // namespace

std::string ParetoPlot::svg() const {
    SvgSurface surface;
    draw(*this, surface);
    return surface.done();
}

Image ParetoPlot::png() const {
    CanvasSurface surface;
    draw(*this, surface);
    return surface.image();
}

} // namespace cmpg

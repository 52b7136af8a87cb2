// The loss over the steps of an optimisation, as an SVG and drawn into a canvas.
#include "imaging/loss_curve.h"

#include "imaging/html.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace cmpg {
namespace {

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

// 1, 2 or 5 times a power of ten: about a quarter of the span.
double tickDistance(double span) {
    const double unit = std::pow(10.0, std::floor(std::log10(span / 4)));
    const double ratio = span / 4 / unit;
    return unit * (ratio < 1.5 ? 1 : ratio < 3.5 ? 2 : ratio < 7.5 ? 5 : 10);
}

void logarithmicTicks(CurveAxes& axes) {
    const int first = int(std::floor(std::log10(axes.low))), last = int(std::ceil(std::log10(axes.high)));
    const int stride = std::max(1, (last - first) / 5);
    const bool fewDecades = last - first <= 2; // then 2 and 5 help
    for (int decade = first; decade <= last; decade += stride)
        for (const double mantissa : {1.0, 2.0, 5.0}) {
            const double tick = mantissa * std::pow(10.0, decade);
            if (tick >= axes.low * (1 - 1e-9) && tick <= axes.high * (1 + 1e-9) && (mantissa == 1 || fewDecades))
                axes.ticks.push_back(tick);
        }
}

void linearTicks(CurveAxes& axes) {
    const double distance = tickDistance(axes.high - axes.low);
    for (auto i = std::llround(std::ceil(axes.low / distance - 1e-9)); double(i) * distance <= axes.high * (1 + 1e-9); ++i)
        axes.ticks.push_back(double(i) * distance);
}

// Ends of the band at a step, as heights on the axes; none where the value or its error is not known.
std::optional<std::pair<double, double>> band(const CurveAxes& axes, std::span<const double> loss, std::span<const double> error, std::size_t i) {
    if (i >= error.size() || !std::isfinite(loss[i]) || !(error[i] >= 0) || std::isinf(error[i]))
        return std::nullopt;
    const auto up = [&](double value) { return std::clamp(axes.up(value), 0.0, 1.0); };
    return std::pair{up(loss[i] - error[i]), up(loss[i] + error[i])};
}

} // namespace

double CurveAxes::across(double step) const {
    return step / steps;
}

double CurveAxes::up(double value) const {
    if (!logarithmic)
        return (value - low) / (high - low);
    return (std::log(std::max(value, low)) - std::log(low)) / (std::log(high) - std::log(low));
}

CurveAxes axesOf(std::span<const double> loss) {
    CurveAxes axes;
    axes.steps = std::max<double>(1, double(loss.size()) - 1);
    double low = 0, high = 0;
    bool any = false;
    for (const double v : loss) {
        if (!std::isfinite(v))
            continue;
        low = any ? std::min(low, v) : v;
        high = any ? std::max(high, v) : v;
        any = true;
    }
    axes.logarithmic = any && low > 0 && high > 3 * low;
    if (axes.logarithmic) {
        axes.low = low / 1.2;
        axes.high = high * 1.2;
        logarithmicTicks(axes);
    } else {
        axes.low = std::min(0.0, low);
        axes.high = high > axes.low ? axes.low + (high - axes.low) * 1.05 : axes.low + 1;
        linearTicks(axes);
    }
    return axes;
}

void drawLossCurve(Canvas& canvas, int x, int y, int width, int height, std::span<const double> loss, std::span<const double> error) {
    const CurveAxes axes = axesOf(loss);
    const Color grid = displayColor(225, 225, 225), ink = displayColor(60, 60, 60), blue = displayColor(0, 90, 170),
                pale = displayColor(185, 210, 235);
    const int left = x + 48, right = x + width - 10, top = y + 8, bottom = y + height - 22;
    for (int i = left; i <= right; ++i) { // column by column: the step nearest to each
        const auto step = std::size_t(std::lround(axes.steps * (i - left) / (right - left)));
        if (const auto ends = step < loss.size() ? band(axes, loss, error, step) : std::nullopt)
            canvas.line(i, bottom - ends->first * (bottom - top), i, bottom - ends->second * (bottom - top), pale);
    }
    for (const double tick : axes.ticks) {
        const int row = int(std::lround(bottom - axes.up(tick) * (bottom - top)));
        canvas.line(left, row, right, row, grid);
        const std::string label = number(tick);
        canvas.text(left - 4 - Canvas::textWidth(label), row - Canvas::textHeight() / 2, label, ink);
    }
    canvas.line(left, top, left, bottom, ink);
    canvas.line(left, bottom, right, bottom, ink);
    const std::string last = number(axes.steps);
    canvas.text(left, bottom + 6, "0", ink);
    canvas.text(right - Canvas::textWidth(last), bottom + 6, last, ink);
    canvas.text((left + right - Canvas::textWidth("step")) / 2, bottom + 6, "step", ink);
    const auto place = [&](std::size_t i) {
        return std::pair{left + axes.across(double(i)) * (right - left), bottom - axes.up(loss[i]) * (bottom - top)};
    };
    for (std::size_t i = 0; i < loss.size(); ++i) {
        if (!std::isfinite(loss[i]))
            continue;
        const auto [x1, y1] = place(i);
        const auto [x0, y0] = i > 0 && std::isfinite(loss[i - 1]) ? place(i - 1) : std::pair{x1, y1};
        canvas.line(x0, y0, x1, y1, blue, 2);
    }
}

std::string lossCurveSvg(std::span<const double> loss, const std::string& title, std::span<const double> error) {
    constexpr double kWidth = 640, kHeight = 360, kLeft = 70, kRight = 620, kTop = 36, kBottom = 315;
    const CurveAxes axes = axesOf(loss);
    const auto px = [&](double step) { return kLeft + axes.across(step) * (kRight - kLeft); };
    const auto py = [&](double value) { return kBottom - axes.up(value) * (kBottom - kTop); };
    char text[256];
    std::string svg;
    const auto add = [&](const char* format, auto... values) {
        std::snprintf(text, sizeof text, format, values...);
        svg += text;
    };
    add("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%g\" height=\"%g\" viewBox=\"0 0 %g %g\" font-family=\"sans-serif\" "
        "font-size=\"12\">\n",
        kWidth, kHeight, kWidth, kHeight);
    svg += "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
    svg += "<text x=\"70\" y=\"22\" font-size=\"14\">" + escapeHtml(title) + "</text>\n";
    for (const double tick : axes.ticks) {
        add("<line x1=\"%g\" y1=\"%.2f\" x2=\"%g\" y2=\"%.2f\" stroke=\"#ddd\"/>", kLeft, py(tick), kRight, py(tick));
        add("<text x=\"%g\" y=\"%.2f\" text-anchor=\"end\">%s</text>\n", kLeft - 6, py(tick) + 4, number(tick).c_str());
    }
    add("<path d=\"M%g %gV%gH%g\" fill=\"none\" stroke=\"#333\"/>\n", kLeft, kTop, kBottom, kRight);
    add("<text x=\"%g\" y=\"%g\">0</text>", kLeft, kBottom + 18);
    add("<text x=\"%g\" y=\"%g\" text-anchor=\"end\">%g</text>", kRight, kBottom + 18, axes.steps);
    add("<text x=\"%g\" y=\"%g\" text-anchor=\"middle\">step</text>\n", (kLeft + kRight) / 2, kBottom + 32);
    // A band of vertical strokes: gaps in the values need no care.
    const double stroke = std::max(1.0, (kRight - kLeft) / axes.steps);
    svg += "<path stroke=\"#b9d2eb\" stroke-width=\"" + number(stroke) + "\" d=\"";
    for (std::size_t i = 0; i < loss.size(); ++i)
        if (const auto ends = band(axes, loss, error, i))
            add("M%.2f %.2fV%.2f", px(double(i)), kBottom - ends->first * (kBottom - kTop), kBottom - ends->second * (kBottom - kTop));
    svg += "\"/>\n";
    svg += "<path fill=\"none\" stroke=\"#005aaa\" stroke-width=\"1.5\" d=\"";
    bool drawing = false;
    for (std::size_t i = 0; i < loss.size(); ++i) {
        const bool finite = std::isfinite(loss[i]);
        if (finite)
            add("%c%.2f %.2f", drawing ? 'L' : 'M', px(double(i)), py(loss[i]));
        drawing = finite;
    }
    return svg + "\"/>\n</svg>\n";
}

} // namespace cmpg

// The loss over the steps of an optimisation, as an SVG and as a part of a drawing.
#include "imaging/loss_curve.h"

#include "imaging/number_text.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace cmpg {
namespace {

constexpr double kLetters = 11;

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
    const auto up = [&](double value) { return std::clamp(axes.up(value), -9.0, 10.0); }; // what is drawn is cut off at 0 and 1
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

namespace {

void draw(Drawing& drawing, double left, double right, double top, double bottom, std::span<const double> loss, std::span<const double> error) {
    using Anchor = Drawing::Anchor;
    const char *const grid = "#e1e1e1", *const ink = "#3c3c3c";
    const CurveAxes axes = axesOf(loss);
    const auto height = [&](double up) { return bottom - up * (bottom - top); };
    const auto across = [&](std::size_t i) { return left + axes.across(double(i)) * (right - left); };
    std::vector<Drawing::Point> above, below; // of the band, broken where a value is missing
    const auto endBand = [&] {
        if (above.size() == 1) { // as wide as a step, at least a pixel
            const double half = std::max(0.5, 0.5 * (right - left) / axes.steps), x = above[0].first;
            above = {{x - half, above[0].second}, {x + half, above[0].second}};
            below = {{x - half, below[0].second}, {x + half, below[0].second}};
        }
        above.insert(above.end(), below.rbegin(), below.rend());
        drawing.area(above, "#b9d2eb", left, top, right, bottom);
        above.clear();
        below.clear();
    };
    for (std::size_t i = 0; i < loss.size(); ++i) {
        if (const auto ends = band(axes, loss, error, i)) {
            below.emplace_back(across(i), height(ends->first));
            above.emplace_back(across(i), height(ends->second));
        } else {
            endBand();
        }
    }
    endBand();
    for (const double tick : axes.ticks) {
        drawing.line(left, height(axes.up(tick)), right, height(axes.up(tick)), grid);
        drawing.text(left - 4, height(axes.up(tick)) + 4, threeDigits(tick), Anchor::End, ink, kLetters);
    }
    drawing.line(left, top, left, bottom, ink);
    drawing.line(left, bottom, right, bottom, ink);
    drawing.text(left, bottom + 14, "0", Anchor::Start, ink, kLetters);
    drawing.text(right, bottom + 14, threeDigits(axes.steps), Anchor::End, ink, kLetters);
    drawing.text((left + right) / 2, bottom + 14, "step", Anchor::Middle, ink, kLetters);
    std::vector<Drawing::Point> run; // broken where a value is missing
    const auto end = [&] {
        if (run.size() == 1)
            drawing.circle(run[0].first, run[0].second, 1, "#005aaa");
        else
            drawing.path(run, "#005aaa", 2);
        run.clear();
    };
    for (std::size_t i = 0; i < loss.size(); ++i) {
        if (std::isfinite(loss[i]))
            run.emplace_back(across(i), height(axes.up(loss[i])));
        else
            end();
    }
    end();
}

} // namespace

void drawLossCurve(Drawing& drawing, int x, int y, int width, int height, std::span<const double> loss, std::span<const double> error) {
    draw(drawing, x + 48, x + width - 10, y + 8, y + height - 22, loss, error);
}

std::string lossCurveSvg(std::span<const double> loss, const std::string& title, std::span<const double> error) {
    constexpr double kWidth = 640, kHeight = 360;
    Drawing drawing(Drawing::Target::Svg, kWidth, kHeight, title);
    drawing.text(70, 22, title, Drawing::Anchor::Start, "#000000", 14);
    draw(drawing, 70, 620, 36, 330, loss, error);
    return drawing.svg();
}

} // namespace cmpg

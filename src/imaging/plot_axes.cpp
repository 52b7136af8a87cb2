// Logarithmic axes of plots.
#include "imaging/plot_axes.h"

#include <algorithm>

namespace cmpg {

namespace {

LogAxis logAxis(double smallest, double largest, double from, double to) {
    double low = std::log10(smallest), high = std::log10(largest);
    const double margin = std::max(0.04 * (high - low), 0.03);
    low -= margin;
    high += margin;
    return {low, high, from, to};
}

} // namespace

bool drawable(double x, double y) { return x > 0 && y > 0 && std::isfinite(x) && std::isfinite(y); }

void PlotBounds::add(double x, double y) {
    if (!drawable(x, y))
        return;
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
}

LogAxis PlotBounds::across(double from, double to) const { return empty() ? logAxis(0.1, 1, from, to) : logAxis(x0, x1, from, to); }
LogAxis PlotBounds::up(double from, double to) const { return empty() ? logAxis(0.1, 1, from, to) : logAxis(y0, y1, from, to); }

std::vector<double> ticksOf(const LogAxis& axis) {
    const int first = int(std::floor(axis.low)), last = int(std::ceil(axis.high));
    const int stride = std::max(1, (last - first) / 6);
    std::vector<double> ticks;
    const double span = axis.high - axis.low;
    for (int decade = first; decade <= last; decade += stride)
        for (const int mantissa : {1, 2, 3, 4, 5, 6, 7, 8, 9}) {
            const double tick = mantissa * std::pow(10.0, decade), place = std::log10(tick);
            const bool wanted = mantissa == 1 || span < 0.7 || (span < 2.2 && (mantissa == 2 || mantissa == 5));
            if (place >= axis.low && place <= axis.high && wanted)
                ticks.push_back(tick);
        }
    return ticks;
}

} // namespace cmpg

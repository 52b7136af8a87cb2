// Logarithmic axes of plots.
#pragma once

#include <cmath>
#include <vector>

namespace cmpg {

struct LogAxis {
    double low, high; // of log10
    double from, to;  // pixels
    double place(double value) const { return from + (std::log10(value) - low) / (high - low) * (to - from); }
};

// Points with a place on logarithmic axes: positive and finite.
bool drawable(double x, double y);

// What the drawable points of a plot span.
struct PlotBounds {
    double x0 = HUGE_VAL, x1 = 0, y0 = HUGE_VAL, y1 = 0;

    void add(double x, double y); // nothing where it is not drawable
    bool empty() const { return !(x1 > 0); }
    // With a margin on both sides; from 0.1 to 1 where nothing is drawable.
    LogAxis across(double from, double to) const;
    LogAxis up(double from, double to) const;
};

// Powers of ten; 2 and 5 times them where they are few; all digits where not even those are there.
std::vector<double> ticksOf(const LogAxis& axis);

} // namespace cmpg

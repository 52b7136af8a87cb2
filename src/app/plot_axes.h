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

// With a margin on both sides. Both values are above 0.
LogAxis logAxis(double smallest, double largest, double from, double to);
// Powers of ten; 2 and 5 times them where they are few; all digits where not even those are there.
std::vector<double> ticksOf(const LogAxis& axis);

} // namespace cmpg

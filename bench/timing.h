// Wall times and their medians.
#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

namespace cmpg::bench {

using Clock = std::chrono::steady_clock;

inline double seconds(Clock::time_point since) { return std::chrono::duration<double>(Clock::now() - since).count(); }

inline double median(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
}

} // namespace cmpg::bench

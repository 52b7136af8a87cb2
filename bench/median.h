// The median of repeated measurements.
#pragma once

#include <algorithm>
#include <vector>

namespace cmpg::bench {

inline double median(std::vector<double> v) {
    std::nth_element(v.begin(), v.begin() + std::ptrdiff_t(v.size() / 2), v.end());
    return v[v.size() / 2];
}

} // namespace cmpg::bench

// How far values are from those of another precision.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

namespace cmpg::test {

// Infinite where it is not a number, which a maximum would drop.
inline double relativeError(double error, double scale) {
    const double relative = error == 0 ? 0 : error / scale;
    return std::isnan(relative) ? std::numeric_limits<double>::infinity() : relative;
}

// Largest |a - b| / scale over the channels; where the scale is 0 both must be 0.
inline double relativeError(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& scale) {
    double worst = 0;
    for (int c = 0; c < 3; ++c)
        worst = std::max(worst, relativeError(a[c] == b[c] ? 0 : std::abs(a[c] - b[c]), scale[c]));
    return worst;
}

} // namespace cmpg::test

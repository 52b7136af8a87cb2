// Units of integer sums.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace cmpg {

// 2^k in two factors a float can hold, k = bits - log2(magnitude); unit = 2^-k.
inline glm::vec2 fixedPointScale(double magnitude, double bits, double& unit) {
    const int k = int(std::clamp(std::floor(bits - std::log2(std::max(magnitude, 1e-60))), -240.0, 240.0));
    unit = std::ldexp(1.0, -k);
    return {std::ldexp(1.0f, k / 2), std::ldexp(1.0f, k - k / 2)};
}

} // namespace cmpg

// Pictures of what one cell of a guide would draw from.
#pragma once

#include "guiding/field/sd_tree.h"
#include "imaging/color.h"

#include <array>

namespace cmpg {

// The equal-area square of all directions: azimuth across, z up. One channel: density relative to that of uniform directions, which is
// 1 everywhere; mean over each pixel, for `edge` a power of two. Score of a quadrant: weights[0] P + weights[1] D+ + weights[2] D-.
// All 0 if nothing has a score.
Image densityMap(const GuideCell& cell, const std::array<double, 3>& weights, int edge);

// P, D+, D- and the mixture wL P + wD (D+ + D-) side by side, logarithmic false colours, each with its scale.
Image drawCell(const GuideCell& cell, std::uint32_t number, double wL, double wD);

} // namespace cmpg

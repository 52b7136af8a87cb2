// What one cell of a guide would draw from, as an image.
#pragma once

#include "guiding/field/sd_tree.h"

#include <cmpg/image.h>

namespace cmpg {

// The equal-area square of all directions: azimuth across, z up. One channel: density relative to that of uniform directions, which is
// 1 everywhere; mean over each pixel, for `edge` a power of two. Score of a quadrant: weights[0] P + weights[1] D+ + weights[2] D-.
// All 0 if nothing has a score.
Image densityMap(const GuideCell& cell, const std::array<double, 3>& weights, int edge);

} // namespace cmpg

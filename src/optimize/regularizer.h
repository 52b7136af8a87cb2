// Total variation of a texture.
#pragma once

#include "scene/scene.h"

#include <span>

namespace cmpg {

// Differences well below this count quadratically, so that the gradient is smooth at 0: a quarter of an 8-bit step.
constexpr double kTotalVariationEpsilon = 1e-3;
// The same of the prior: wide enough that steps of an optimiser do not chatter about 0.
constexpr double kPriorEpsilon = 1e-2;

// Returns weight * TV and adds its gradient. TV is the sum over pairs of horizontal and vertical neighbours of
// sqrt(d^2 + eps^2) - eps, divided by the number of entries. Neighbours across an edge count where the texture repeats; an
// environment wraps around horizontally. 0 for constants.
double addTotalVariation(const Parameter& parameter, double weight, std::span<double> gradient, double epsilon = kTotalVariationEpsilon);

} // namespace cmpg

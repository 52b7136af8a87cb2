// The passes of an optimisation that measure the curvature of its loss.
#pragma once

#include <cstdint>

namespace cmpg {

constexpr std::uint32_t kPrimalPass = 0, kGradientPass = 1; // PassKey::pass
constexpr float kCurvatureStep = 0.05f; // by which parameters change where the bound of the curvature is measured, in their units

} // namespace cmpg

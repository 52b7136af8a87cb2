// The passes of an optimisation that measure the curvature of its loss.
#pragma once

#include <cstdint>

namespace cmpg {

constexpr std::uint32_t kPrimalPass = 0, kGradientPass = 1; // PassKey::pass

} // namespace cmpg

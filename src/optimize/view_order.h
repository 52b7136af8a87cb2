// Which views a step sees, where it does not see all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cmpg {

// The views of a step: `perStep` after those of the step before, from random orders of all views, one order after the other. So every view is
// equally likely, and each is seen once before any is seen again. All of them, in their own order, where `perStep` is 0 or not less than `views`.
std::vector<std::size_t> viewsOfStep(std::uint64_t seed, std::uint32_t step, std::size_t views, std::uint32_t perStep);

} // namespace cmpg

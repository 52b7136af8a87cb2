// The gradient sums on the device: 64-bit integers, an entry for each of the differentiable parameters.
#pragma once

#include "base/communicator.h"
#include "render/gradient_units.h"
#include "render/scene_buffers.h"

namespace cmpg {

void clearSums(Buffer& sums, std::uint64_t entries);

// Adds those of all ranks up; all have the result.
void shareSums(Buffer& sums, std::uint64_t entries, Communicator& ranks);

// Whether the largest sum is large enough for rounding not to show, or nothing was contributed at all. Reads no further than the first large one.
bool resolved(const Buffer& sums, std::uint64_t entries, const Unsummed& unsummed);

// Adds the sums of all parameters to `gradients`: a vector for each.
void addSums(const Buffer& sums, const SceneBuffers& buffers, const Scene& scene, std::span<const std::uint32_t> differentiable,
             const GradientUnits& units, std::vector<std::vector<double>>& gradients);

} // namespace cmpg

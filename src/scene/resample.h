// Textures and images of another size.
#pragma once

#include "scene/scene.h"

#include <cstdint>
#include <span>
#include <vector>

namespace cmpg {

// `from`: width x height x channels, row-major. Texels of fewer are means of the area they cover, those of more are interpolated as kernels do between texels.
std::vector<float> resampled(std::span<const float> from, std::uint32_t channels, glm::uvec2 size, glm::uvec2 newSize, Wrap wrapU, Wrap wrapV);

} // namespace cmpg

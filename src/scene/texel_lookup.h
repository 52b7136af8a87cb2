// Which texels of a parameter a surface point reads, as the kernels find them.
#pragma once

#include "scene/scene.h"

#include <array>

namespace cmpg {

// Row-major indices of texels, with weights that add up to 1. The same index may stand more than once.
struct TexelLookup {
    std::array<std::uint32_t, 4> texel;
    std::array<float, 4> weight;
};
// uv0, uv1: TEXCOORD_0 and _1 of the point. `parameter`: a texture of a surface, no environment.
TexelLookup lookUp(const Parameter& parameter, const glm::vec2& uv0, const glm::vec2& uv1);

} // namespace cmpg

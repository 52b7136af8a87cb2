// Other sizes of parameters: a constant becomes a texture, a texture gets more texels or fewer.
#pragma once

#include "scene/scene.h"

#include <cstdint>

namespace cmpg {

// Gives a parameter width x height texels; what it looks like stays, as far as they can show it. Renderers of the scene are to be made anew. Error(Usage) where a
// texture has no place: triangles without texture coordinates, normals without a normal map, directions of anisotropy, an environment of one colour.
void resize(Scene& scene, std::uint32_t parameter, std::uint32_t width, std::uint32_t height);

} // namespace cmpg

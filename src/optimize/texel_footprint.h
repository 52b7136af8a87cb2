// How fine a texture is in a picture.
#pragma once

#include "scene/camera_ray.h"

#include <span>

namespace cmpg {

// Texels along the edge of a pixel: the root of how many texels the pictures show by how many pixels they cover, of surfaces within them, hidden
// ones too, since what hides them hides both. Many triangles are sampled. 0 where no picture shows the texture, as of an environment, and of constants.
double texelsPerPixel(const Scene& scene, std::uint32_t parameter, std::span<const CameraRays> pictures);

} // namespace cmpg

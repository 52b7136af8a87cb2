// How fine a texture is in a picture.
#pragma once

#include "scene/camera_ray.h"

#include <span>

namespace cmpg {

// Of surfaces within the pictures, hidden ones too, since what hides them hides both, but not of what mirrors and lenses show. Many triangles are sampled.
// All 0 where no picture shows the texture, as of an environment, and of constants.
struct TexelFootprint {
    // Texels along the edge of a pixel: the root of how many texels the pictures show by how many pixels they cover.
    double mean = 0;
    // A power of two. So many texels, at least, lie along the shorter side of what a pixel covers, but for a fiftieth of what is shown.
    double least = 0;
};
TexelFootprint texelFootprint(const Scene& scene, std::uint32_t parameter, std::span<const CameraRays> pictures);

// How much of its samples a pixel needs where all that is recovered are textures of these: less where a texel covers more than four pixels, since it has the
// samples of all of them. From 1/4 to 1; 1 where the footprint of one is not known.
double sampleShare(std::span<const TexelFootprint> footprints);

} // namespace cmpg

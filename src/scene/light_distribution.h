// How light sampling picks a light and a direction of the environment: host tables, deterministic, without Vulkan.
#pragma once

#include "scene/bvh.h"
#include "shared/light.h"

namespace cmpg {

struct LightDistribution {
    std::vector<gpu::GpuLight> lights;    // selection by `cumulative`, in table order
    std::vector<float> triangleDensity;   // per triangle in BVH order: probability per unit area; empty without emissive triangles
    std::vector<float> environmentCdf;    // (H-1) marginal, then (H-1) x W conditional cumulative probabilities; empty without
    float environmentProbability = 0;     // of selecting the environment
    // MIS compensation (Karlik et al., "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance Sampling", 2019): what is no
    // brighter than the map's mean is left to scattered rays, which find it as often, and light samples go where it is brighter. So much is taken
    // off the sum of a texel's channels: three times the mean. 0 for a map that is differentiated, whose dark texels must be found, too, and for
    // one that is even.
    float environmentCompensation = 0;
};

// The unit normal of a triangle as kernels have it; towards the side that sees the corners counter-clockwise. In double: of a needle's nearly
// parallel edges float leaves no more than a hint of the direction, and of very small ones nothing.
glm::vec3 faceNormal(const glm::dvec3& v0, const glm::dvec3& v1, const glm::dvec3& v2);

// Selection probability follows the emitted power (environment: over a disc of the scene's radius, and mostly what is above its mean); an emitter whose
// radiance is differentiated is never left out. Texture-mapped emission counts with the mean over its texture.
LightDistribution buildLights(const Scene& scene, const Bvh& bvh, const std::vector<std::uint32_t>& differentiable);

} // namespace cmpg

// What a scene requires of the renderer, as plain data: decides which kernels are specialised how and which buffers exist.
#pragma once

#include "scene/scene.h"
#include "shared/features.h"

namespace cmpg {

struct FeatureSet {
    bool diffuse = false, specular = false;
    std::uint32_t texturedSlots = 0; // bit per SlotKind that some material looks up
    bool packedTextures = false;
    bool vertexNormals = false, texcoord1 = false, colors = false, tangents = false, alphaMask = false;
    bool emission = false, environment = false;
    bool triangleLights = false, punctualLights = false, environmentLight = false; // sampled
    std::uint32_t differentiated = 0; // bit per SlotKind

    // Values of the specialization constants for one mode, in the order of shaders/shared/features.h.
    struct Pass {
        std::uint32_t mode = gpu::kModeRender;
        bool sobol = true, frozen = false, layers = false;
        bool guided = false, record = false, roulette = false, measure = false, oneSign = false;
        std::uint32_t maxDepth = 8, threads = 1;
        auto operator<=>(const Pass&) const = default;
    };
    std::array<std::uint32_t, gpu::kFeatureCount> constants(const Pass& pass) const;
    std::array<std::uint32_t, gpu::kTraceCount> traceConstants(std::uint32_t threads, bool refill) const;
    std::uint32_t attributeTexels() const { return 2 + tangents + colors; } // vec4s a vertex
    // One line each: name, whether it is on, why.
    std::vector<std::string> describe() const;
};

// Looks at everything once: only materials that some triangle uses count.
FeatureSet analyse(const Scene& scene, const std::vector<std::uint32_t>& differentiable, bool lightSampling);
// Everything on, for comparison.
FeatureSet allFeatures(const Scene& scene, const std::vector<std::uint32_t>& differentiable, bool lightSampling);

// Materials at least one triangle uses.
std::vector<bool> usedMaterials(const Scene& scene);
// Largest value of a parameter over its channels and texels; 0 for an empty one.
float largestValue(const Parameter& parameter);

} // namespace cmpg

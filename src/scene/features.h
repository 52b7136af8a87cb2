// What a scene requires of the renderer, as plain data: decides which kernels are specialised how, which buffers exist, what is uploaded.
#pragma once

#include "scene/scene.h"
#include "shared/bvh_node.h"
#include "shared/features.h"
#include "shared/wavefront.h"

#include <map>

namespace cmpg {

// What is asked of a renderer beside the scene.
struct FeatureRequest {
    std::vector<std::uint32_t> differentiable = {}; // parameters
    bool lightSampling = true;
    bool guiding = false;    // passes may be guided; in reverse mode paths may split
    bool everything = false; // all features on, whether they are needed or not: for comparison, the results are the same
};

// Surfaces by what they take to shade. Each class that a scene has is shaded by a kernel of its own.
enum class ShadingClass : std::uint32_t {
    Plain = gpu::kClassPlain,     // diffuse by a constant colour: no texture, emission or derivative
    Diffuse = gpu::kClassDiffuse, // diffuse alone, beside others with more lobes or normal maps
    Other = gpu::kClassOther,
    Unlit = gpu::kClassUnlit, // no material's: plain, met where no light counts yet, so that none is sampled
};

// What the surfaces of a class require.
struct SurfaceFeatures {
    bool diffuse = false, specular = false; // lobes of metallic-roughness
    std::uint32_t models = 0; // bit per SurfaceModel, and gpu::kModelsSmooth ...
    std::uint32_t texturedSlots = 0; // bit per SlotKind that some material looks up
    bool emission = false, vertexNormals = false;
    bool differentiated = false; // some slot that scattering depends on
};

// How textures are stored and looked up, all of a scene.
struct TextureFeatures {
    std::uint32_t packedSlots = 0, colorSlots = 0, scalarSlots = 0; // bit per SlotKind of which some texture has 8 bits a channel, three channels, one
    std::uint32_t wraps = 0;             // bit per Wrap
    bool linear = false, nearest = false;
    bool transforms = false;             // some texture's coordinates are moved

    void add(const Parameter& texture);
    void addLookUp(const auto& texture) { // a Parameter, AlphaTexture or DirectionTexture
        wraps |= 1u << std::uint32_t(texture.wrapU) | 1u << std::uint32_t(texture.wrapV);
        (texture.nearest ? nearest : linear) = true;
        transforms |= texture.uvTransform != glm::mat3x2(1, 0, 0, 1, 0, 0);
    }
};

struct FeatureSet {
    bool diffuse = false, specular = false; // lobes of metallic-roughness
    std::uint32_t models = 0; // bit per SurfaceModel, and gpu::kModelsSmooth ...
    std::uint32_t texturedSlots = 0; // bit per SlotKind that some material looks up
    TextureFeatures textures;
    bool vertexNormals = false, texcoord1 = false, colors = false, tangents = false, alphaMask = false, coverage = false;
    bool emission = false, environment = false;
    bool triangleLights = false, punctualLights = false, environmentLight = false; // sampled
    bool spotsByAngle = false;
    bool pixelFilter = false; // some camera has another than the box
    std::uint32_t lightCandidates = 1;                                             // per light sample; the scene decides, whatever else is on
    std::uint32_t fewLights = 0;      // 2, 4: no more lights than that, whatever parameters become; 0: any number
    std::uint32_t differentiated = 0; // bit per SlotKind
    bool guiding = false, roulette = false; // some pass may use them
    bool everything = false;                // every pass does

    // By material: bit per SlotKind whose value some kernel reads. 0: no triangle uses the material, nothing of it is uploaded.
    std::vector<std::uint32_t> readSlots;

    std::vector<ShadingClass> shadingClass; // by material
    std::map<ShadingClass, SurfaceFeatures> classes; // those of some surface; empty where all features are on

    bool lightSampling() const { return triangleLights || punctualLights || environmentLight; }
    bool texcoords() const { return texturedSlots != 0 || alphaMask; }
    bool attributes() const { return vertexNormals || colors || texcoords(); }
    std::uint32_t attributeTexels() const { return 1 + texcoords() + tangents + colors; } // vec4s a vertex

    // Values of the specialization constants for one mode, in the order of shaders/shared/features.h.
    struct Pass {
        std::uint32_t mode = gpu::kModeRender;
        bool sobol = true, frozen = false, layers = false;
        bool guided = false, record = false, roulette = false, measure = false, oneSign = false;
        std::uint32_t maxDepth = 8, threads = 1, bvhDepth = gpu::kMaxBvhDepth;
        auto operator<=>(const Pass&) const = default;
    };
    std::array<std::uint32_t, gpu::kFeatureCount> constants(const Pass& pass) const;
    // Of the kernel that shades one class.
    std::array<std::uint32_t, gpu::kFeatureCount> constants(const Pass& pass, ShadingClass surfaces) const;
    std::array<std::uint32_t, gpu::kTraceCount> traceConstants(std::uint32_t threads, std::uint32_t bvhDepth) const;
    // Whether a pass shades plain vertices apart whose light no derivative is made of: only where kAllLight (shaders/scene/features.glsl) is false,
    // since other passes need the light of paths without kLightCounts, too.
    bool shadesUnlit(const Pass& pass) const;
    // Whether a pass scans the vertices of differentiated surfaces apart from the others.
    bool scansClasses(const Pass& pass) const;
    bool differentiatesLight() const; // emission or the environment's radiance
    // Whether all a pass makes are gradients of what surfaces scatter.
    bool derivesSurfacesAlone(const Pass& pass) const;
    // Name and what is on, of every feature.
    std::vector<std::pair<std::string, std::string>> describe() const;
};

// Looks at everything once: only materials that some triangle uses count, and of those only what has an effect.
FeatureSet analyse(const Scene& scene, const FeatureRequest& request);

// Largest value of a parameter over its channels and texels; 0 for an empty one.
float largestValue(const Parameter& parameter);

// Mean over the channels of what a light sends out: light sampling leaves one without any alone.
double meanIntensity(const PunctualLight& light);

} // namespace cmpg

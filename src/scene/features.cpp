// Analysis of a scene into its feature set.
#include "scene/features.h"

#include <algorithm>

namespace cmpg {

std::vector<bool> usedMaterials(const Scene& scene) {
    std::vector<bool> used(scene.materials.size(), false);
    for (const Triangle& t : scene.geometry.triangles)
        used[t.material] = true;
    return used;
}

float largestValue(const Parameter& p) {
    if (!p.values.empty())
        return *std::max_element(p.values.begin(), p.values.end());
    const float scale = std::max({p.scale.x, p.scale.y, p.scale.z});
    const std::uint8_t top = p.bytes.empty() ? 0 : *std::max_element(p.bytes.begin(), p.bytes.end());
    return scale * float(top) / 255.0f + std::max({p.bias.x, p.bias.y, p.bias.z});
}

namespace {

const Parameter& slot(const Scene& scene, const Material& m, SlotKind kind) {
    return scene.parameters[m.parameters[std::size_t(kind)]];
}

} // namespace

FeatureSet analyse(const Scene& scene, const std::vector<std::uint32_t>& differentiable, bool lightSampling) {
    FeatureSet f;
    std::vector<bool> wanted(scene.parameters.size(), false);
    for (const std::uint32_t p : differentiable) {
        wanted[p] = true;
        f.differentiated |= 1u << std::uint32_t(scene.parameters[p].kind);
    }
    const std::vector<bool> used = usedMaterials(scene);
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        if (!used[i])
            continue;
        const Material& m = scene.materials[i];
        // A lobe is needed when it has a value or a derivative that somebody asked for.
        const auto changes = [&](SlotKind kind) { return wanted[m.parameters[std::size_t(kind)]]; };
        const bool metal = largestValue(slot(scene, m, SlotKind::Metallic)) > 0 || changes(SlotKind::Metallic);
        const bool specular = largestValue(slot(scene, m, SlotKind::Specular)) > 0 || changes(SlotKind::Specular);
        const Parameter& metallic = slot(scene, m, SlotKind::Metallic);
        const bool allMetal = !metallic.textured && metallic.values.size() == 1 && metallic.values[0] >= 1 && !changes(SlotKind::Metallic);
        f.specular |= metal || specular;
        f.diffuse |= !allMetal;
        for (std::uint32_t k = 0; k < kMaterialSlots; ++k) {
            const Parameter& p = scene.parameters[m.parameters[k]];
            const bool isNormal = SlotKind(k) == SlotKind::Normal;
            const bool differentiated = wanted[m.parameters[k]];
            if (p.entries() > p.channels || (isNormal && (m.hasNormalMap || differentiated))) {
                f.texturedSlots |= 1u << k;
                f.packedTextures |= p.values.empty();
                f.texcoord1 |= p.texcoord == 1;
            }
        }
        f.alphaMask |= m.alphaMask;
        const bool emits = largestValue(slot(scene, m, SlotKind::Emission)) > 0 || changes(SlotKind::Emission);
        f.emission |= emits;
        f.triangleLights |= emits && lightSampling;
    }
    f.vertexNormals =
        std::any_of(scene.geometry.normals.begin(), scene.geometry.normals.end(), [](const glm::vec3& n) { return glm::dot(n, n) > 0; });
    f.texcoord1 = f.texcoord1 && !scene.geometry.uv1.empty();
    f.colors = !scene.geometry.colors.empty();
    f.tangents = (f.texturedSlots >> std::uint32_t(SlotKind::Normal) & 1u) && !scene.geometry.tangents.empty();
    f.environment = scene.environment.has_value();
    f.environmentLight = f.environment && lightSampling && largestValue(scene.parameters[scene.environment->parameter]) > 0;
    f.punctualLights = !scene.lights.empty() && lightSampling;
    if (f.alphaMask)
        f.packedTextures = true;
    return f;
}

FeatureSet allFeatures(const Scene& scene, const std::vector<std::uint32_t>& differentiable, bool lightSampling) {
    FeatureSet f = analyse(scene, differentiable, lightSampling);
    f.diffuse = f.specular = f.packedTextures = true;
    f.texturedSlots = (1u << kMaterialSlots) - 1;
    f.vertexNormals = f.texcoord1 = f.colors = f.tangents = f.alphaMask = true;
    f.emission = f.environment = true;
    f.triangleLights = f.punctualLights = f.environmentLight = lightSampling;
    return f;
}

std::array<std::uint32_t, gpu::kFeatureCount> FeatureSet::constants(const Pass& pass) const {
    std::array<std::uint32_t, gpu::kFeatureCount> c{};
    c[gpu::kFeatureMode] = pass.mode;
    c[gpu::kFeatureDifferentiated] = pass.mode == gpu::kModeRender ? 0 : differentiated;
    c[gpu::kFeatureDiffuse] = diffuse;
    c[gpu::kFeatureSpecular] = specular;
    c[gpu::kFeatureTextures] = texturedSlots;
    c[gpu::kFeaturePackedTextures] = packedTextures;
    c[gpu::kFeatureVertexNormals] = vertexNormals;
    c[gpu::kFeatureTexcoord1] = texcoord1;
    c[gpu::kFeatureColors] = colors;
    c[gpu::kFeatureTangents] = tangents;
    c[gpu::kFeatureAlphaMask] = alphaMask;
    c[gpu::kFeatureEmission] = emission;
    c[gpu::kFeatureEnvironment] = environment;
    c[gpu::kFeatureTriangleLights] = triangleLights;
    c[gpu::kFeaturePunctualLights] = punctualLights;
    c[gpu::kFeatureEnvironmentLight] = environmentLight;
    c[gpu::kFeatureSobol] = pass.sobol;
    c[gpu::kFeatureFrozen] = pass.frozen;
    c[gpu::kFeatureLayers] = pass.layers;
    c[gpu::kFeatureMaxDepth] = pass.maxDepth;
    c[gpu::kFeatureThreads] = pass.threads;
    c[gpu::kFeatureGuided] = pass.guided;
    c[gpu::kFeatureRecord] = pass.record;
    c[gpu::kFeatureRoulette] = pass.roulette;
    c[gpu::kFeatureMeasure] = pass.measure;
    c[gpu::kFeatureSigned] = pass.oneSign;
    return c;
}

std::array<std::uint32_t, gpu::kTraceCount> FeatureSet::traceConstants(std::uint32_t threads, bool refill) const {
    std::array<std::uint32_t, gpu::kTraceCount> c{};
    c[gpu::kTraceThreads] = threads;
    c[gpu::kTraceRefill] = refill;
    c[gpu::kTraceAlphaMask] = alphaMask;
    c[gpu::kTraceAttributeTexels] = attributeTexels();
    c[gpu::kTraceTexcoord1] = texcoord1;
    c[gpu::kTraceColors] = colors;
    return c;
}

std::vector<std::string> FeatureSet::describe() const {
    const auto line = [](const char* name, bool on) { return std::string(name) + (on ? "  on" : "  off"); };
    std::string looked;
    for (std::uint32_t k = 0; k < kMaterialSlots; ++k)
        if (texturedSlots >> k & 1u)
            looked += std::string(" ") + slotName(SlotKind(k));
    return {
        "textures " + (looked.empty() ? " off" : looked),
        line("diffuse lobe", diffuse),
        line("specular lobe", specular),
        line("packed textures", packedTextures),
        line("vertex normals", vertexNormals),
        line("second texture coordinates", texcoord1),
        line("vertex colours", colors),
        line("tangents", tangents),
        line("alpha mask", alphaMask),
        line("emissive surfaces", emission),
        line("environment", environment),
        line("sampling of emissive triangles", triangleLights),
        line("sampling of punctual lights", punctualLights),
        line("sampling of the environment", environmentLight),
    };
}

} // namespace cmpg

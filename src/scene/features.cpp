// Analysis of a scene into its feature set.
#include "scene/features.h"

#include "base/error.h"
#include "shared/material.h"

#include <algorithm>
#include <bit>

namespace cmpg {

float largestValue(const Parameter& p) {
    if (!p.values.empty())
        return *std::max_element(p.values.begin(), p.values.end());
    const float scale = std::max({p.scale.x, p.scale.y, p.scale.z});
    const std::uint8_t top = p.bytes.empty() ? 0 : *std::max_element(p.bytes.begin(), p.bytes.end());
    return scale * float(top) / 255.0f + std::max({p.bias.x, p.bias.y, p.bias.z});
}

double meanIntensity(const PunctualLight& light) { return (double(light.intensity.x) + light.intensity.y + light.intensity.z) / 3; }

void TextureFeatures::add(const Parameter& texture) {
    const std::uint32_t slot = 1u << std::uint32_t(texture.kind);
    packedSlots |= texture.values.empty() ? slot : 0;
    (texture.channels == 1 ? scalarSlots : colorSlots) |= slot;
    addLookUp(texture);
}

namespace {

// Candidates of a light sample. An environment alone is sampled so well that a choice among its directions costs more than it brings, and spoils the even
// spread of Sobol points; beside other lights, where the choice is among lights, its directions are dear.
constexpr std::uint32_t kLightCandidates = 8, kMixedCandidates = 4;
constexpr std::uint32_t kEverySlot = (1u << kMaterialSlots) - 1;
constexpr std::uint32_t kEveryModel = ((1u << (std::uint32_t(SurfaceModel::Plastic) + 1)) - 1) | gpu::kModelsSmooth | gpu::kModelsRoughReflection | gpu::kModelsRoughDielectric |
                                      gpu::kModelsBeckmann | gpu::kModelsGgx | gpu::kModelsOneSided | gpu::kModelsCoatNormals |
                                      gpu::kModelsAbsorbing;

bool needsTangents(std::uint32_t slots, std::uint32_t models) {
    return (slots >> gpu::kSlotNormal & 1u) || (slots >> gpu::kSlotAnisotropy & 1u) || (models & gpu::kModelsCoatNormals) != 0;
}

struct Analysis {
    const Scene& scene;
    std::vector<bool> asked; // by parameter: differentiable
    FeatureSet f;

    // A parameter that may be positive, now or when somebody changes it.
    bool matters(std::uint32_t parameter) const { return asked[parameter] || largestValue(scene.parameters[parameter]) > 0; }

    void addMaterial(std::size_t index, bool lightSampling) {
        const Material& m = scene.materials[index];
        const auto of = [&](SlotKind kind) { return m.parameters[std::size_t(kind)]; };
        const Parameter& metallic = scene.parameters[of(SlotKind::Metallic)];
        const bool allMetal = metallic.values.size() == 1 && metallic.values[0] >= 1 && !asked[of(SlotKind::Metallic)];
        const bool metal = matters(of(SlotKind::Metallic)), specular = !allMetal && matters(of(SlotKind::Specular));
        const bool emits = matters(of(SlotKind::Emission));
        if (m.model == SurfaceModel::MetallicRoughness) {
            f.specular |= metal || specular;
            f.diffuse |= !allMetal;
        }
        addModel(m);
        f.alphaMask |= m.alphaMask;
        f.coverage |= m.alphaMask && m.coverage;
        f.emission |= emits;
        f.triangleLights |= emits && lightSampling;

        std::uint32_t& read = f.readSlots[index];
        const auto reads = [&](SlotKind kind, bool wanted) { read |= wanted || asked[of(kind)] ? 1u << std::uint32_t(kind) : 0; };
        reads(SlotKind::BaseColor, true);
        if (m.model == SurfaceModel::MetallicRoughness) {
            reads(SlotKind::Roughness, metal || specular);
            reads(SlotKind::Metallic, metal);
            reads(SlotKind::Specular, specular);
        } else {
            for (const SlotKind kind : {SlotKind::Roughness, SlotKind::Metallic, SlotKind::Specular})
                reads(kind, readsSlot(m, kind));
        }
        reads(SlotKind::Emission, emits);
        reads(SlotKind::Normal, m.hasNormalMap);
        for (std::uint32_t k = 0; k < kMaterialSlots; ++k) {
            if (m.parameters[k] == kNoParameter)
                continue;
            if (SlotKind(k) == SlotKind::Anisotropy) {
                if (readsAnisotropy(m, read)) {
                    read |= 1u << k;
                    if (m.anisotropyDirection != ~0u)
                        addLookUp(scene.directionTextures[m.anisotropyDirection]);
                }
            } else if (SlotKind(k) == SlotKind::SheenRoughness || SlotKind(k) == SlotKind::SheenColor) {
                read |= readsSheen(m) ? 1u << k : 0;
            } else if (k >= kCommonSlots)
                reads(SlotKind(k), m.model == SurfaceModel::MetallicRoughness || SlotKind(k) == SlotKind::Weight);
            const Parameter& p = scene.parameters[m.parameters[k]];
            if ((read >> k & 1u) && (p.entries() > p.channels || SlotKind(k) == SlotKind::Normal || k >= kCommonSlots)) {
                f.texturedSlots |= 1u << k;
                f.textures.add(p);
                f.texcoord1 |= p.texcoord == 1;
            }
        }
        if (hasClearcoatNormals(m))
            addLookUp(scene.directionTextures[m.clearcoatNormals]);
        if (m.alphaMask && m.alphaTexture != ~0u)
            addLookUp(scene.alphaTextures[m.alphaTexture]);
    }

    void addLookUp(const auto& texture) {
        f.textures.addLookUp(texture);
        f.texcoord1 |= texture.texcoord == 1;
    }

    // glTF's strength has no effect while it is 0.
    bool readsAnisotropy(const Material& m, std::uint32_t read) const {
        const std::uint32_t strength = m.parameters[std::size_t(SlotKind::Anisotropy)];
        const bool alpha = m.model != SurfaceModel::MetallicRoughness && m.roughnessIsAlpha;
        return hasAnisotropy(m) && (asked[strength] || ((read >> std::uint32_t(SlotKind::Roughness) & 1u) && (alpha || matters(strength))));
    }

    // A black one has no effect.
    bool readsSheen(const Material& m) const {
        return hasSheen(m) && (asked[m.parameters[std::size_t(SlotKind::SheenRoughness)]] || matters(m.parameters[std::size_t(SlotKind::SheenColor)]));
    }

    void addModel(const Material& m) {
        f.models |= 1u << std::uint32_t(m.model) | (hasClearcoatNormals(m) ? gpu::kModelsCoatNormals : 0) | (m.oneSided ? gpu::kModelsOneSided : 0) | (m.absorption != glm::vec3(0) ? gpu::kModelsAbsorbing : 0);
        if (m.model == SurfaceModel::MetallicRoughness) return;
        if (isSmooth(m)) {
            f.models |= gpu::kModelsSmooth;
            return;
        }
        f.models |= m.model == SurfaceModel::Dielectric ? gpu::kModelsRoughDielectric : gpu::kModelsRoughReflection;
        f.models |= m.microfacets == Microfacets::Beckmann ? gpu::kModelsBeckmann : gpu::kModelsGgx;
    }

    ShadingClass classOf(std::size_t index) const {
        const Material& m = scene.materials[index];
        const std::uint32_t baseColor = m.parameters[std::size_t(SlotKind::BaseColor)];
        const std::uint32_t scattering = f.readSlots[index] & gpu::kScatteringSlots;
        if (m.model != SurfaceModel::MetallicRoughness || scattering != 1u << std::uint32_t(SlotKind::BaseColor) || m.alphaMask)
            return ShadingClass::Other;
        const bool constant = scene.parameters[baseColor].entries() == scene.parameters[baseColor].channels;
        return constant && scattering == f.readSlots[index] && !asked[baseColor] ? ShadingClass::Plain : ShadingClass::Diffuse;
    }

    // A kernel for plain surfaces and one for all others; where some of these have more lobes or normal maps, one for the diffuse among them.
    void findClasses(const std::vector<bool>& used) {
        f.shadingClass.assign(scene.materials.size(), ShadingClass::Other);
        f.classes = {};
        bool others = false, diffuse = false;
        for (std::size_t i = 0; i < used.size(); ++i) {
            if (used[i])
                f.shadingClass[i] = classOf(i);
            others |= used[i] && f.shadingClass[i] == ShadingClass::Other;
            diffuse |= used[i] && f.shadingClass[i] == ShadingClass::Diffuse;
        }
        for (ShadingClass& c : f.shadingClass)
            if (!others && c == (diffuse ? ShadingClass::Diffuse : ShadingClass::Plain))
                c = ShadingClass::Other;
        for (std::size_t i = 0; i < used.size(); ++i)
            if (used[i])
                f.classes.try_emplace(f.shadingClass[i]);
        for (auto& [shadingClass, features] : f.classes)
            features = featuresOf(shadingClass, used);
    }

    SurfaceFeatures featuresOf(ShadingClass shadingClass, const std::vector<bool>& used) const {
        Analysis part{scene, asked, {}};
        part.f.readSlots.assign(scene.materials.size(), 0);
        SurfaceFeatures s;
        for (std::size_t i = 0; i < used.size(); ++i) {
            if (!used[i] || f.shadingClass[i] != shadingClass)
                continue;
            part.addMaterial(i, false);
            for (std::uint32_t k = 0; k < kMaterialSlots; ++k)
                s.differentiated |= (gpu::kScatteringSlots >> k & 1u) && scene.materials[i].parameters[k] != kNoParameter && asked[scene.materials[i].parameters[k]];
        }
        const Geometry& g = scene.geometry;
        const auto hasNormal = [&](std::uint32_t vertex) { return glm::dot(g.normals[vertex], g.normals[vertex]) > 0; };
        s.vertexNormals = f.vertexNormals && std::any_of(g.triangles.begin(), g.triangles.end(), [&](const Triangle& t) {
            return f.shadingClass[t.material] == shadingClass && std::any_of(t.vertices.begin(), t.vertices.end(), hasNormal);
        });
        s.diffuse = part.f.diffuse;
        s.specular = part.f.specular;
        s.models = part.f.models;
        s.texturedSlots = part.f.texturedSlots;
        s.emission = part.f.emission;
        return s;
    }

    void addGeometry() {
        const Geometry& g = scene.geometry;
        f.vertexNormals = std::any_of(g.normals.begin(), g.normals.end(), [](const glm::vec3& n) { return glm::dot(n, n) > 0; });
        f.colors = !g.colors.empty();
        f.tangents = needsTangents(f.texturedSlots, f.models) && !g.tangents.empty();
    }

    void turnEverythingOn(bool lightSampling) {
        f.everything = true;
        f.shadingClass.assign(scene.materials.size(), ShadingClass::Other);
        f.classes.clear();
        f.diffuse = f.specular = true;
        f.texturedSlots = kEverySlot;
        f.textures = {kEverySlot, kEverySlot, kEverySlot, 0b111, true, true, true};
        f.models = kEveryModel;
        f.vertexNormals = f.texcoord1 = f.colors = f.tangents = f.alphaMask = f.coverage = true;
        f.emission = f.environment = f.pixelFilter = true;
        f.fewLights = 0;
        f.triangleLights = f.punctualLights = f.environmentLight = f.spotsByAngle = lightSampling;
        f.differentiated = kEverySlot | 1u << std::uint32_t(SlotKind::Radiance);
        f.guiding = f.roulette = true;
        f.readSlots.assign(scene.materials.size(), kEverySlot);
    }
};

// As kFeatureWrap has it.
std::uint32_t wrapOf(const TextureFeatures& textures) {
    if (textures.wraps == 0)
        return std::uint32_t(Wrap::Repeat);
    return std::has_single_bit(textures.wraps) ? std::uint32_t(std::countr_zero(textures.wraps)) : gpu::kWrapsDiffer;
}

} // namespace

FeatureSet analyse(const Scene& scene, const FeatureRequest& request) {
    Analysis a{scene, std::vector<bool>(scene.parameters.size(), false), {}};
    for (const std::uint32_t p : request.differentiable) {
        a.asked[p] = true;
        a.f.differentiated |= 1u << std::uint32_t(scene.parameters[p].kind);
    }
    for (const Material& m : scene.materials)
        if (const std::uint32_t normal = m.parameters[std::size_t(SlotKind::Normal)]; a.asked[normal] && !hasNormalDerivative(m))
            throw Error(ErrorKind::Usage, scene.parameters[normal].name + " cannot be differentiated",
                        "normals turn what " + m.name + " reflects in single directions or refracts, and such derivatives are not known here",
                        "leave this parameter out");
    std::vector<bool> used(scene.materials.size(), false);
    for (const Triangle& t : scene.geometry.triangles)
        used[t.material] = true;
    for (std::size_t i = 0; i < used.size(); ++i)
        if (const std::uint32_t other = scene.materials[i].blendWith; used[i] && other != kNoMaterial)
            used[other] = true;
    a.f.readSlots.assign(scene.materials.size(), 0);
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
        if (used[i])
            a.addMaterial(i, request.lightSampling);
    a.addGeometry();
    a.findClasses(used);
    a.f.pixelFilter = std::any_of(scene.cameras.begin(), scene.cameras.end(), [](const Camera& c) { return c.filter.kind != PixelFilter::Kind::Box; });
    a.f.environment = scene.environment && a.matters(scene.environment->parameter);
    a.f.environmentLight = a.f.environment && request.lightSampling;
    const auto shining = std::count_if(scene.lights.begin(), scene.lights.end(), [](const PunctualLight& l) { return meanIntensity(l) > 0; });
    a.f.punctualLights = request.lightSampling && shining > 0;
    a.f.spotsByAngle = a.f.punctualLights && std::any_of(scene.lights.begin(), scene.lights.end(), [](const PunctualLight& l) { return l.byAngle; });
    const bool others = a.f.triangleLights || shining > 0;
    a.f.lightCandidates = a.f.environmentLight && others ? kMixedCandidates : a.f.triangleLights || shining > 1 ? kLightCandidates : 1;
    std::size_t lights = std::size_t(shining) + a.f.environmentLight;
    for (const Triangle& t : scene.geometry.triangles)
        lights += a.matters(scene.materials[t.material].parameters[std::size_t(SlotKind::Emission)]);
    a.f.fewLights = lights <= 2 ? 2 : lights <= 4 ? 4 : 0;
    a.f.guiding = request.guiding;
    a.f.roulette = request.guiding && !request.differentiable.empty();
    if (request.everything)
        a.turnEverythingOn(request.lightSampling);
    return a.f;
}

std::array<std::uint32_t, gpu::kFeatureCount> FeatureSet::constants(const Pass& pass) const {
    std::array<std::uint32_t, gpu::kFeatureCount> c{};
    c[gpu::kFeatureMode] = pass.mode;
    c[gpu::kFeatureDifferentiated] = pass.mode == gpu::kModeRender ? 0 : differentiated;
    c[gpu::kFeatureDiffuse] = diffuse;
    c[gpu::kFeatureSpecular] = specular;
    c[gpu::kFeatureTextures] = texturedSlots;
    c[gpu::kFeaturePackedSlots] = textures.packedSlots;
    c[gpu::kFeatureColorSlots] = textures.colorSlots;
    c[gpu::kFeatureScalarSlots] = textures.scalarSlots;
    c[gpu::kFeatureWrap] = wrapOf(textures);
    c[gpu::kFeatureFilter] = !textures.nearest ? gpu::kFilterLinear : textures.linear ? gpu::kFiltersDiffer : gpu::kFilterNearest;
    c[gpu::kFeatureTextureTransforms] = textures.transforms;
    c[gpu::kFeatureVertexNormals] = vertexNormals;
    c[gpu::kFeatureTexcoord1] = texcoord1;
    c[gpu::kFeatureColors] = colors;
    c[gpu::kFeatureTangents] = tangents;
    c[gpu::kFeatureAlphaMask] = alphaMask;
    c[gpu::kFeatureCoverage] = coverage;
    c[gpu::kFeatureEmission] = emission;
    c[gpu::kFeatureEnvironment] = environment;
    c[gpu::kFeatureTriangleLights] = triangleLights;
    c[gpu::kFeaturePunctualLights] = punctualLights;
    c[gpu::kFeatureEnvironmentLight] = environmentLight;
    c[gpu::kFeatureSobol] = pass.sobol;
    c[gpu::kFeatureFrozen] = pass.frozen;
    c[gpu::kFeatureLayers] = pass.layers;
    c[gpu::kFeatureGuided] = pass.guided;
    c[gpu::kFeatureRecord] = pass.record;
    c[gpu::kFeatureRoulette] = pass.roulette;
    c[gpu::kFeatureMeasure] = pass.measure;
    c[gpu::kFeatureSigned] = pass.oneSign;
    c[gpu::kFeatureLightCandidates] = everything && lightCandidates > 1 ? 0 : lightCandidates; // so that the same kernels serve more scenes; a weight of 1 rounds otherwise
    c[gpu::kFeatureFewLights] = fewLights;
    c[gpu::kFeatureModels] = models;
    c[gpu::kFeatureSpotsByAngle] = spotsByAngle;
    c[gpu::kFeaturePixelFilter] = pixelFilter;
    c[gpu::kFeatureAttributeTexels] = attributeTexels();
    c[gpu::kFeatureSingleDirections] = (models & gpu::kModelsSmooth) != 0;
    c[gpu::kFeatureClass] = gpu::kClassOther;
    c[gpu::kFeatureClassDifferentiated] = true;
    c[gpu::kFeatureClasses] = 1u << gpu::kClassEscaped | 1u << gpu::kClassOther;
    for (const auto& [each, features] : classes)
        c[gpu::kFeatureClasses] |= 1u << std::uint32_t(each);
    if (shadesUnlit(pass))
        c[gpu::kFeatureClasses] |= 1u << gpu::kClassUnlit;
    return c;
}

std::array<std::uint32_t, gpu::kFeatureCount> FeatureSet::constants(const Pass& pass, ShadingClass surfaces) const {
    std::array<std::uint32_t, gpu::kFeatureCount> c = constants(pass);
    c[gpu::kFeatureClass] = std::uint32_t(surfaces);
    const bool unlit = surfaces == ShadingClass::Unlit;
    const auto found = classes.find(unlit ? ShadingClass::Plain : surfaces);
    if (found == classes.end())
        return c; // all features are on
    const SurfaceFeatures& s = found->second;
    c[gpu::kFeatureDiffuse] = s.diffuse;
    c[gpu::kFeatureSpecular] = s.specular;
    c[gpu::kFeatureModels] = s.models;
    c[gpu::kFeatureTextures] = s.texturedSlots | (lightSampling() ? texturedSlots & 1u << gpu::kSlotEmission : 0); // that of lights is sampled from anywhere
    c[gpu::kFeatureVertexNormals] = s.vertexNormals;
    c[gpu::kFeatureTangents] = tangents && needsTangents(s.texturedSlots, s.models);
    c[gpu::kFeatureEmission] = s.emission;
    c[gpu::kFeatureClassDifferentiated] = s.differentiated;
    if (unlit)
        c[gpu::kFeatureTriangleLights] = c[gpu::kFeaturePunctualLights] = c[gpu::kFeatureEnvironmentLight] = false;
    return c;
}

bool FeatureSet::differentiatesLight() const { return (differentiated & (1u << gpu::kSlotEmission | 1u << gpu::kSlotRadiance)) != 0; }

bool FeatureSet::derivesSurfacesAlone(const Pass& pass) const { return pass.mode == gpu::kModeReverse && !pass.measure && !pass.record && !differentiatesLight(); }

bool FeatureSet::shadesUnlit(const Pass& pass) const {
    return (pass.mode == gpu::kModeForward || pass.mode == gpu::kModeReverse) && !pass.record && pass.maxDepth > 1 && !differentiatesLight() && lightSampling() &&
           classes.contains(ShadingClass::Plain);
}

bool FeatureSet::scansClasses(const Pass& pass) const {
    if (pass.roulette || pass.record)
        return false; // lavapipe rounds the sums of copies and of records in another order where derivatives do not follow
    return (pass.mode == gpu::kModeForward || pass.mode == gpu::kModeReverse) &&
           std::any_of(classes.begin(), classes.end(), [](const auto& c) { return c.second.differentiated; });
}

std::array<std::uint32_t, gpu::kTraceCount> FeatureSet::traceConstants(std::uint32_t threads, std::uint32_t bvhDepth) const {
    std::array<std::uint32_t, gpu::kTraceCount> c{};
    c[gpu::kTraceThreads] = threads;
    // On the way to a leaf every box node but the last puts one group aside at most.
    if (bvhDepth <= gpu::kMaxTraceStack + 1)
        c[gpu::kTraceStack] = std::max(bvhDepth, 2u) - 1;
    c[gpu::kTraceAlphaMask] = alphaMask;
    c[gpu::kTraceCoverage] = coverage;
    c[gpu::kTraceAttributeTexels] = attributeTexels();
    c[gpu::kTraceTexcoord1] = texcoord1;
    c[gpu::kTraceColors] = colors;
    return c;
}

std::vector<std::pair<std::string, std::string>> FeatureSet::describe() const {
    const auto slots = [](std::uint32_t bits) {
        std::string names;
        for (std::uint32_t k = 0; k <= kMaterialSlots; ++k) // the last is the environment's radiance
            if (bits >> k & 1u) {
                names += names.empty() ? "" : " ";
                names += slotName(SlotKind(k));
            }
        return names.empty() ? "off" : names;
    };
    const auto modelNames = [&] {
        std::string names;
        const auto add = [&](std::uint32_t bit, const char* name) {
            if (!(models & bit)) return;
            names += names.empty() ? "" : " ";
            names += name;
        };
        add(1u << gpu::kModelDielectric, "dielectric");
        add(1u << gpu::kModelThinDielectric, "pane");
        add(1u << gpu::kModelConductor, "conductor");
        add(1u << gpu::kModelPlastic, "plastic");
        return names;
    };
    const bool lookUpsDiffer = wrapOf(textures) == gpu::kWrapsDiffer || (textures.linear && textures.nearest);
    const auto text = [](bool on) { return std::string(on ? "on" : "off"); };
    return {
        {"textures", slots(texturedSlots)},
        {"differentiated", slots(differentiated)},
        {"diffuse lobe", text(diffuse)},
        {"specular lobe", text(specular)},
        {"dielectrics, conductors and plastics", modelNames().empty() ? "off" : modelNames()},
        {"absorbing interiors", text(models & gpu::kModelsAbsorbing)},
        {"normals of clear coats", text(models & gpu::kModelsCoatNormals)},
        {"surfaces black from behind", text(models & gpu::kModelsOneSided)},
        {"blends of materials", text(texturedSlots >> std::uint32_t(SlotKind::Weight) & 1u)},
        {"packed textures", slots(textures.packedSlots)},
        {"textures of one channel", slots(textures.scalarSlots)},
        {"textures with transforms", text(textures.transforms)},
        {"textures that wrap or filter unlike others", text(lookUpsDiffer)},
        {"kernels of plain and of diffuse surfaces", text(classes.contains(ShadingClass::Plain)) + " " + text(classes.contains(ShadingClass::Diffuse))},
        {"vertex normals", text(vertexNormals)},
        {"second texture coordinates", text(texcoord1)},
        {"vertex colours", text(colors)},
        {"tangents", text(tangents)},
        {"alpha mask", text(alphaMask)},
        {"partial coverage", text(coverage)},
        {"emissive surfaces", text(emission)},
        {"environment", text(environment)},
        {"sampling of emissive triangles", text(triangleLights)},
        {"sampling of punctual lights", text(punctualLights)},
        {"sampling of the environment", text(environmentLight)},
        {"candidates of a light sample", std::to_string(lightCandidates)},
        {"pixel filter", text(pixelFilter)},
        {"guided directions", text(guiding)},
        {"roulette and splitting", text(roulette)},
    };
}

} // namespace cmpg

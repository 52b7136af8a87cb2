// Uploads a scene in the layouts of shaders/shared.
#include "render/scene_buffers.h"

#include "base/error.h"
#include "shared/bindings.h"
#include "shared/material.h"
#include "shared/wavefront.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <stdexcept>

namespace cmpg {

namespace {

using Words = std::vector<std::uint32_t>;

static_assert(kMaterialSlots == gpu::kSlotsPerMaterial);
static_assert(std::uint32_t(SurfaceModel::MetallicRoughness) == gpu::kModelMetallicRoughness && std::uint32_t(SurfaceModel::Dielectric) == gpu::kModelDielectric &&
              std::uint32_t(SurfaceModel::ThinDielectric) == gpu::kModelThinDielectric && std::uint32_t(SurfaceModel::Conductor) == gpu::kModelConductor &&
              std::uint32_t(SurfaceModel::Plastic) == gpu::kModelPlastic);

constexpr std::uint64_t kCoatBytes = std::uint64_t(gpu::kCoatRows) * gpu::kCoatColumns * sizeof(glm::vec4);

std::uint32_t texelsOf(const Parameter& p) {
    const std::uint64_t n = std::uint64_t(p.width) * p.height;
    return std::uint32_t(p.channels == 1 ? (n + 3) / 4 : n);
}

} // namespace

bool SceneBuffers::isDifferentiable(std::uint32_t parameter) const {
    return std::find(differentiable_.begin(), differentiable_.end(), parameter) != differentiable_.end();
}

bool SceneBuffers::isLookedUp(std::uint32_t material, std::uint32_t k) const {
    const std::uint32_t parameter = scene_.materials[material].parameters[k];
    if (parameter == kNoParameter || !(features_.readSlots[material] >> k & 1u))
        return false;
    const Parameter& p = scene_.parameters[parameter];
    // A constant normal is the surface's own unless somebody changes it.
    return k >= kCommonSlots || p.entries() > p.channels || (p.kind == SlotKind::Normal && isDifferentiable(parameter));
}

void SceneBuffers::chooseMaterials() {
    materialPlace_.assign(scene_.materials.size(), gpu::kNone);
    alphaSlot_.assign(scene_.alphaTextures.size(), gpu::kNone);
    for (std::uint32_t m = 0; m < scene_.materials.size(); ++m)
        if (features_.readSlots[m]) {
            materialPlace_[m] = std::uint32_t(materialsUp_.size());
            materialsUp_.push_back(m);
        }
    for (const std::uint32_t m : materialsUp_) {
        const Material& material = scene_.materials[m];
        if (!material.alphaMask || material.alphaTexture == ~0u || alphaSlot_[material.alphaTexture] != gpu::kNone)
            continue;
        alphaSlot_[material.alphaTexture] = std::uint32_t(materialsUp_.size() * gpu::kSlotsPerMaterial + alphaTexturesUp_.size());
        alphaTexturesUp_.push_back(material.alphaTexture);
    }
    directionSlot_.assign(scene_.directionTextures.size(), gpu::kNone);
    const auto keepDirections = [&](std::uint32_t direction, std::uint32_t m, SlotKind kind) {
        if (direction == ~0u || !isLookedUp(m, std::uint32_t(kind)) || directionSlot_[direction] != gpu::kNone)
            return;
        directionSlot_[direction] = std::uint32_t(materialsUp_.size() * gpu::kSlotsPerMaterial + alphaTexturesUp_.size() + directionTexturesUp_.size());
        directionTexturesUp_.push_back(direction);
    };
    for (const std::uint32_t m : materialsUp_) {
        keepDirections(scene_.materials[m].anisotropyDirection, m, SlotKind::Anisotropy);
        keepDirections(scene_.materials[m].clearcoatNormals, m, SlotKind::Clearcoat);
    }
}

SceneBuffers::SceneBuffers(Device& device, Scene& scene, const FeatureSet& features, const std::vector<std::uint32_t>& differentiable, bool second)
    : device_(device), scene_(scene), features_(features), differentiable_(differentiable), hasSecond_(second) {
    for (const std::uint32_t p : differentiable_) {
        scene_.parameters[p].materialise();
        gradientOffsets_.push_back(gradientEntries_);
        gradientEntries_ += scene_.parameters[p].entries();
    }
    bvh_ = buildBvh(scene_.geometry);
    chooseMaterials();
    uploadGeometry(device);
    layOutValues(device);
    uploadSlots(device);
    layOutCoats();
    materials_ = Buffer(device, "materials", std::max<std::uint64_t>(1, materialsUp_.size()) * sizeof(gpu::GpuMaterial) * (hasSecond_ ? 2 : 1) + coats_.size() * kCoatBytes,
                        MemoryKind::Scene, Texel::Rgba32ui);
    info_ = Buffer(device, "scene info", sizeof(gpu::SceneInfo), MemoryKind::Scene);
    uploadMaterials(false);
    if (hasSecond_)
        uploadMaterials(true);
    uploadLights();
}

void SceneBuffers::uploadGeometry(Device& device) {
    const Geometry& g = scene_.geometry;
    const std::size_t count = bvh_.order.size();
    nodes_ = Buffer(device, "bvh nodes", bvh_.records.size() * sizeof(BvhRecord), MemoryKind::Scene, Texel::Rgba32ui);
    nodes_.uploadAll(bvh_.records);

    materialBoxes_.resize(scene_.materials.size());
    std::vector<glm::vec4> corners(std::max<std::size_t>(1, count) * 3, glm::vec4(0));
    std::vector<glm::uvec4> indices(std::max<std::size_t>(1, count), glm::uvec4(0));
    for (std::size_t i = 0; i < count; ++i) {
        const Triangle& t = g.triangles[bvh_.order[i]];
        const glm::vec3 v0 = g.positions[t.vertices[0]], v1 = g.positions[t.vertices[1]], v2 = g.positions[t.vertices[2]];
        const glm::vec3 normal = faceNormal(v0, v1, v2);
        corners[3 * i] = glm::vec4(v0, normal.x);
        corners[3 * i + 1] = glm::vec4(v1 - v0, normal.y);
        corners[3 * i + 2] = glm::vec4(v2 - v0, normal.z);
        indices[i] = {t.vertices[0], t.vertices[1], t.vertices[2], materialPlace_[t.material]};
        for (const glm::vec3 corner : {v0, v1, v2})
            materialBoxes_[t.material].grow(corner);
    }
    triangles_ = Buffer(device, "triangles", corners.size() * 16, MemoryKind::Scene, Texel::Rgba32f);
    triangles_.uploadAll(corners);
    indices_ = Buffer(device, "triangle indices", indices.size() * 16, MemoryKind::Scene, Texel::Rgba32ui);
    indices_.uploadAll(indices);

    if (!features_.attributes())
        return;
    const std::size_t stride = features_.attributeTexels();
    std::vector<glm::vec4> attributes(std::max<std::size_t>(1, g.positions.size()) * stride, glm::vec4(0));
    for (std::size_t v = 0; v < g.positions.size(); ++v) {
        glm::vec4* a = &attributes[v * stride];
        const glm::vec3 n = v < g.normals.size() ? g.normals[v] : glm::vec3(0);
        const glm::vec2 uv0 = v < g.uv0.size() ? g.uv0[v] : glm::vec2(0), uv1 = v < g.uv1.size() ? g.uv1[v] : glm::vec2(0);
        a[0] = glm::vec4(n, uv0.x);
        if (features_.texcoords())
            a[1] = glm::vec4(uv0.y, uv1, 0);
        if (features_.tangents)
            a[2] = v < g.tangents.size() ? g.tangents[v] : glm::vec4(0);
        if (features_.colors)
            a[stride - 1] = v < g.colors.size() ? g.colors[v] : glm::vec4(1);
    }
    attributes_ = Buffer(device, "vertex attributes", attributes.size() * 16, MemoryKind::Scene, Texel::Rgba32f);
    attributes_.uploadAll(attributes);
}

void SceneBuffers::layOutValues(Device& device) {
    places_.assign(scene_.parameters.size(), gpu::kNone);
    std::vector<bool> read(scene_.parameters.size(), false);
    for (const std::uint32_t m : materialsUp_)
        for (std::uint32_t k = 0; k < kMaterialSlots; ++k)
            if (isLookedUp(m, k))
                read[scene_.materials[m].parameters[k]] = true;
    if (features_.environment && scene_.environment)
        read[scene_.environment->parameter] = true;

    Words packed;
    for (std::uint32_t i = 0; i < scene_.parameters.size(); ++i) {
        const Parameter& p = scene_.parameters[i];
        if (!read[i])
            continue;
        if (!p.values.empty()) {
            places_[i] = valueTexels_;
            valueTexels_ += texelsOf(p);
            continue;
        }
        places_[i] = std::uint32_t(packed.size());
        for (std::size_t t = 0; t < std::size_t(p.width) * p.height; ++t) {
            std::uint32_t word = 0;
            for (std::uint32_t c = 0; c < 3; ++c)
                word |= std::uint32_t(p.bytes[t * p.channels + (p.channels == 3 ? c : 0)]) << (8 * c);
            packed.push_back(word);
        }
    }
    if (valueTexels_ > 0)
        values_ = Buffer(device, "parameter values", std::uint64_t(valueTexels_) * 16 * (hasSecond_ ? 2 : 1), MemoryKind::Parameters, Texel::Rgba32f);
    for (std::uint32_t i = 0; i < scene_.parameters.size(); ++i)
        if (places_[i] != gpu::kNone && !scene_.parameters[i].values.empty()) {
            writeValues(i, scene_.parameters[i].values, 0);
            if (hasSecond_)
                writeValues(i, scene_.parameters[i].values, valueTexels_);
        }
    alphaPlace_ = std::uint32_t(packed.size());
    for (const std::uint32_t a : alphaTexturesUp_)
        packed.insert(packed.end(), scene_.alphaTextures[a].alpha.begin(), scene_.alphaTextures[a].alpha.end());
    directionPlace_ = std::uint32_t(packed.size());
    for (const std::uint32_t d : directionTexturesUp_)
        for (const glm::vec2 direction : scene_.directionTextures[d].directions)
            packed.push_back(glm::packSnorm2x16(direction));
    if (!packed.empty()) {
        packed_ = Buffer(device, "packed textures", packed.size() * 4, MemoryKind::Scene, Texel::R32ui);
        packed_.uploadAll(packed);
    }
}

void SceneBuffers::writeValues(std::uint32_t parameter, std::span<const float> values, std::uint32_t base) {
    const Parameter& p = scene_.parameters[parameter];
    constexpr std::size_t kPortion = 1 << 18; // texels
    const std::size_t perTexel = p.channels == 1 ? 4 : 3, all = texelsOf(p);
    for (std::size_t at = 0; at < all; at += kPortion) {
        std::vector<float> texels(std::min(kPortion, all - at) * 4, 0.0f);
        const std::span<const float> part = values.subspan(at * perTexel, std::min(std::min(kPortion, all - at) * perTexel, values.size() - at * perTexel));
        if (p.channels == 1)
            std::copy(part.begin(), part.end(), texels.begin());
        else
            for (std::size_t t = 0; t < part.size() / 3; ++t)
                std::copy_n(part.begin() + std::ptrdiff_t(3 * t), 3, texels.begin() + std::ptrdiff_t(4 * t));
        values_.uploadAll(texels, std::uint64_t(places_[parameter] + base + at) * 16);
    }
}

void SceneBuffers::uploadSlots(Device& device) {
    if (!features_.texcoords() && !features_.differentiated)
        return;
    std::vector<gpu::GpuSlot> slots(materialsUp_.size() * gpu::kSlotsPerMaterial + alphaTexturesUp_.size() + directionTexturesUp_.size());
    for (gpu::GpuSlot& s : slots)
        s.gradient = s.other = gpu::kNone;
    const auto sampling = [](const auto& t) {
        return std::uint32_t(t.wrapU) | std::uint32_t(t.wrapV) << gpu::kSlotWrapVShift | (t.nearest ? gpu::kSlotNearest : 0) |
               (t.texcoord == 1 ? gpu::kSlotTexcoord1 : 0);
    };
    const auto place = [](gpu::GpuSlot& s, const glm::mat3x2& m) {
        s.uvMatrix = {m[0].x, m[0].y, m[1].x, m[1].y};
        s.uvTranslation = m[2];
    };
    for (std::size_t m = 0; m < materialsUp_.size(); ++m)
        for (std::uint32_t k = 0; k < kMaterialSlots; ++k) {
            const std::uint32_t index = scene_.materials[materialsUp_[m]].parameters[k];
            if (index == kNoParameter)
                continue;
            const Parameter& p = scene_.parameters[index];
            gpu::GpuSlot& s = slots[m * gpu::kSlotsPerMaterial + k];
            s.offset = places_[index];
            s.width = p.width;
            s.height = p.height;
            s.flags = sampling(p) | (p.channels == 1 ? gpu::kSlotScalar : 0) | (p.values.empty() ? gpu::kSlotPacked : 0) | (p.srgb ? gpu::kSlotSrgb : 0);
            place(s, p.uvTransform);
            if (const std::uint32_t other = scene_.materials[materialsUp_[m]].blendWith; SlotKind(k) == SlotKind::Weight && other != kNoMaterial)
                s.other = materialPlace_[other];
            if (const Material& material = scene_.materials[materialsUp_[m]]; SlotKind(k) == SlotKind::Clearcoat && hasClearcoatNormals(material))
                s.other = directionSlot_[material.clearcoatNormals];
            if (SlotKind(k) == SlotKind::Anisotropy) {
                const Material& material = scene_.materials[materialsUp_[m]];
                const std::uint32_t direction = material.anisotropyDirection;
                s.other = direction != ~0u ? directionSlot_[direction] : gpu::kNone;
                s.flags |= tangentTexcoord(scene_, material) == 1 ? gpu::kSlotTangents1 : 0;
            }
            const auto found = std::find(differentiable_.begin(), differentiable_.end(), index);
            s.gradient = found == differentiable_.end() ? gpu::kNone : std::uint32_t(gradientOffsets_[std::size_t(found - differentiable_.begin())]);
            s.packedScale = glm::vec4(p.scale, 0);
            s.packedBias = glm::vec4(p.bias, 0);
        }
    const auto fill = [&](gpu::GpuSlot& s, const auto& texture, std::size_t texels, std::uint32_t& at) {
        s.offset = at;
        s.width = texture.width;
        s.height = texture.height;
        s.flags = sampling(texture);
        place(s, texture.uvTransform);
        at += std::uint32_t(texels);
    };
    std::uint32_t at = alphaPlace_;
    for (const std::uint32_t texture : alphaTexturesUp_) {
        const AlphaTexture& a = scene_.alphaTextures[texture];
        fill(slots[alphaSlot_[texture]], a, a.alpha.size(), at);
    }
    at = directionPlace_;
    for (const std::uint32_t texture : directionTexturesUp_) {
        const DirectionTexture& d = scene_.directionTextures[texture];
        fill(slots[directionSlot_[texture]], d, d.directions.size(), at);
    }
    slots_ = Buffer(device, "material slots", std::max<std::size_t>(1, slots.size()) * sizeof(gpu::GpuSlot), MemoryKind::Scene, Texel::Rgba32ui);
    slots_.uploadAll(slots);
}

void SceneBuffers::layOutCoats() {
    std::vector<std::pair<float, Microfacets>> kinds;
    for (const std::uint32_t index : materialsUp_) {
        const Material& m = scene_.materials[index];
        coatOf_.push_back(gpu::kNone);
        if (m.model != SurfaceModel::Plastic || m.smooth)
            continue;
        const std::pair kind(m.ior, m.microfacets);
        const auto found = std::find(kinds.begin(), kinds.end(), kind);
        coatOf_.back() = std::uint32_t(found - kinds.begin());
        if (found != kinds.end())
            continue;
        kinds.push_back(kind);
        coats_.emplace_back(std::clamp(double(m.ior), 1e-3, 1e3), m.microfacets);
    }
}

// The rows that the material may read: unless alpha varies the one it falls in, and its neighbours, because a device's square root may round otherwise.
void SceneBuffers::uploadCoat(std::uint32_t material, float alpha) {
    const std::uint32_t parameter = scene_.materials[materialsUp_[material]].parameters[std::size_t(SlotKind::Roughness)];
    const bool varies = scene_.parameters[parameter].entries() > 1 || isDifferentiable(parameter);
    constexpr float kMinAlpha = 1e-3f; // as kernels have it
    const std::uint32_t row = CoatTable::rowOf(std::max(alpha, kMinAlpha));
    const std::uint32_t first = varies || row == 0 ? 0 : row - 1, last = varies ? gpu::kCoatRows - 1 : std::min(row + 1, gpu::kCoatRows - 1);
    std::vector<glm::vec4> texels(std::size_t(gpu::kCoatRows) * gpu::kCoatColumns);
    coats_[coatOf_[material]].write(first, last, texels);
    texels = {texels.begin() + std::ptrdiff_t(first * gpu::kCoatColumns), texels.begin() + std::ptrdiff_t((last + 1) * gpu::kCoatColumns)};
    materials_.uploadAll(texels, std::uint64_t(coatTexel(material) + first * gpu::kCoatColumns) * 16);
}

// First texel of the material's table.
std::uint32_t SceneBuffers::coatTexel(std::uint32_t material) const {
    const std::size_t materials = std::max<std::size_t>(1, materialsUp_.size()) * (hasSecond_ ? 2 : 1);
    return std::uint32_t(materials * gpu::kMaterialTexels + coatOf_[material] * (kCoatBytes / 16));
}

void SceneBuffers::uploadMaterials(bool second) {
    std::vector<gpu::GpuMaterial> materials(materialsUp_.size());
    for (std::size_t i = 0; i < materials.size(); ++i) {
        const Material& m = scene_.materials[materialsUp_[i]];
        gpu::GpuMaterial& out = materials[i];
        const auto values = [&](SlotKind kind) -> glm::vec3 {
            const std::uint32_t index = m.parameters[std::size_t(kind)];
            const Parameter& p = scene_.parameters[index];
            const auto other = second_.find(index);
            const std::vector<float>& v = second && other != second_.end() ? other->second : p.values;
            if (v.empty() || p.entries() > p.channels)
                return glm::vec3(0);
            return p.channels == 3 ? glm::vec3(v[0], v[1], v[2]) : glm::vec3(v[0]);
        };
        out.baseColor = values(SlotKind::BaseColor);
        out.roughness = values(SlotKind::Roughness).x;
        out.metallic = values(SlotKind::Metallic).x;
        out.specular = values(SlotKind::Specular).x;
        out.emission = values(SlotKind::Emission);
        out.ior = m.ior;
        out.specularColor = m.specularColor;
        if (m.model != SurfaceModel::MetallicRoughness)
            out.ior = std::clamp(m.ior, 1e-3f, 1e3f); // squares stay numbers
        if (m.model == SurfaceModel::Conductor) {
            out.metallic = m.eta.x;
            out.specular = m.eta.y;
            out.ior = m.eta.z;
            out.specularColor = m.k;
        } else if (m.model != SurfaceModel::MetallicRoughness) {
            out.specularColor = values(SlotKind::Specular);
            out.metallic = out.specular = 0;
        }
        if (m.model == SurfaceModel::Plastic && m.smooth) {
            out.metallic = float(CoatTable::reflectedDiffuse(1 / double(out.ior)));
        } else if (m.model == SurfaceModel::Plastic) {
            out.specular = float(coatTexel(std::uint32_t(i)));
            uploadCoat(std::uint32_t(i), m.roughnessIsAlpha ? out.roughness : out.roughness * out.roughness);
        }
        out.flags |= std::uint32_t(m.model) << gpu::kModelShift | (m.oneSided ? gpu::kMaterialOneSided : 0);
        if (m.model == SurfaceModel::MetallicRoughness)
            out.flags |= (m.anisotropyByAspect ? gpu::kMaterialAspect : 0) | (hasSheen(m) && isLookedUp(materialsUp_[i], gpu::kSlotSheenColor) ? gpu::kMaterialSheen : 0);
        else
            out.flags |= (isSmooth(m) ? gpu::kMaterialSmooth : 0) | (m.microfacets == Microfacets::Beckmann ? gpu::kMaterialBeckmann : 0) |
                         (m.model == SurfaceModel::Plastic && m.nonlinear ? gpu::kMaterialNonlinear : 0) | (m.roughnessIsAlpha ? 0 : gpu::kMaterialAlphaSquared);
        out.flags |= hasAnisotropy(m) && isLookedUp(materialsUp_[i], gpu::kSlotAnisotropy) ? gpu::kMaterialAnisotropic : 0;
        const float cutoff = m.coverage ? 1.0f : m.alphaCutoff;
        out.alphaCutoff = cutoff > 0 ? cutoff / m.alphaFactor : 0.0f; // infinite for a factor of 0: nothing is left
        if (m.absorption != glm::vec3(0)) {
            out.flags |= gpu::kMaterialAbsorbs;
            out.metallic = m.absorption.x;
            out.specular = m.absorption.y;
            out.alphaCutoff = m.absorption.z;
        }
        out.alphaSlot = m.alphaMask && m.alphaTexture != ~0u ? alphaSlot_[m.alphaTexture] : gpu::kNone;
        for (std::uint32_t k = 0; k < gpu::kFlaggedSlots; ++k) {
            out.flags |= isLookedUp(materialsUp_[i], k) ? 1u << k : 0;
            out.flags |= isDifferentiable(m.parameters[k]) ? 1u << (gpu::kDifferentiatedShift + k) : 0;
        }
        out.flags |= (m.blendWith != kNoMaterial ? gpu::kMaterialBlend : 0) |
                     (isDifferentiable(m.parameters[std::size_t(SlotKind::Weight)]) ? gpu::kMaterialWeightDifferentiated : 0);
        out.flags |= (emits(m) ? gpu::kMaterialEmissive : 0) | (m.alphaMask ? gpu::kMaterialAlphaMask : 0) | (m.coverage ? gpu::kMaterialCoverage : 0);
        out.flags |= std::uint32_t(features_.shadingClass[materialsUp_[i]]) << gpu::kMaterialClassShift;
    }
    materials_.uploadAll(materials, second ? materials.size() * sizeof(gpu::GpuMaterial) : 0);
}

bool SceneBuffers::emits(const Material& material) const {
    const std::uint32_t emission = material.parameters[std::size_t(SlotKind::Emission)];
    return largestValue(scene_.parameters[emission]) > 0 || isDifferentiable(emission);
}

void SceneBuffers::boundEmitters(gpu::SceneInfo& info) const {
    Box all, emitters;
    for (std::size_t m = 0; m < materialBoxes_.size(); ++m) {
        all.grow(materialBoxes_[m]);
        if (emits(scene_.materials[m]))
            emitters.grow(materialBoxes_[m]);
    }
    // Many times what rounding may do to the hits of a ray.
    const glm::vec3 largest = glm::max(glm::abs(all.low), glm::abs(all.high));
    const float margin = 1e-5f * std::max({largest.x, largest.y, largest.z});
    info.emittersLow = emitters.low - margin;
    info.emittersHigh = emitters.high + margin;
}

void SceneBuffers::uploadLights() {
    const bool environment = features_.environment && scene_.environment;
    LightDistribution d;
    if (features_.lightSampling())
        d = buildLights(scene_, bvh_, differentiable_);
    for (gpu::GpuLight& light : d.lights)
        if (light.kind == gpu::kLightTriangle)
            light.kind |= materialPlace_[scene_.geometry.triangles[bvh_.order[light.triangle]].material] << gpu::kLightKindBits;
    // A parameter update can add or remove lights only when its scene has emitters in the first place; sizes are upper bounds.
    const auto put = [&](Buffer& buffer, const char* name, const auto& v, Texel texel) {
        const std::uint64_t bytes = v.size() * sizeof(v[0]);
        if (v.empty())
            return;
        if (!buffer || buffer.size() < bytes)
            buffer = Buffer(device_, name, bytes, MemoryKind::Scene, texel);
        buffer.uploadAll(v);
    };
    put(lights_, "lights", d.lights, Texel::Rgba32ui);
    put(lightDensity_, "light density", d.triangleDensity, Texel::R32f);
    if (features_.environmentLight)
        put(environmentCdf_, "environment distribution", d.environmentCdf, Texel::R32f);

    gpu::SceneInfo info{};
    info.lights = std::uint32_t(d.lights.size());
    info.lightCandidates = features_.lightCandidates;
    info.secondMaterials = hasSecond_ ? std::uint32_t(materialsUp_.size()) : 0;
    info.secondTexels = hasSecond_ ? valueTexels_ : 0;
    info.environmentDistance = 1e30f;
    boundEmitters(info);
    info.environment.gradient = gpu::kNone;
    if (environment) {
        const Parameter& p = scene_.parameters[scene_.environment->parameter];
        info.environment.width = p.width;
        info.environment.height = p.height;
        info.environment.texels = places_[scene_.environment->parameter];
        info.environment.cosRotation = std::cos(scene_.environment->rotation);
        info.environment.sinRotation = std::sin(scene_.environment->rotation);
        info.environment.probability = d.environmentProbability;
        info.environment.compensation = d.environmentCompensation;
        for (std::size_t i = 0; i < differentiable_.size(); ++i)
            if (differentiable_[i] == scene_.environment->parameter)
                info.environment.gradient = std::uint32_t(gradientOffsets_[i]);
    }
    info_.upload(std::as_bytes(std::span(&info, 1)));
}

void SceneBuffers::bind(Bindings& b) const {
    b.set(gpu::kBindNodes, nodes_);
    b.set(gpu::kBindTriangles, triangles_);
    b.set(gpu::kBindIndices, indices_);
    b.set(gpu::kBindAttributes, attributes_);
    b.set(gpu::kBindMaterials, materials_);
    b.set(gpu::kBindSlots, slots_);
    b.set(gpu::kBindValues, values_);
    b.set(gpu::kBindPacked, packed_);
    b.set(gpu::kBindLights, lights_);
    b.set(gpu::kBindLightDensity, lightDensity_);
    b.set(gpu::kBindEnvironmentCdf, environmentCdf_);
    b.set(gpu::kBindScene, info_);
}

void SceneBuffers::requireEntries(std::uint32_t parameter, std::size_t count) const {
    const Parameter& p = scene_.parameters[parameter];
    if (count != p.entries())
        throw Error(ErrorKind::Usage, p.name + " takes " + std::to_string(p.entries()) + " values, not " + std::to_string(count),
                    "the values were made for another shape", "see `inspect` for the parameter's shape");
}

void SceneBuffers::setParameter(std::uint32_t parameter, std::span<const float> values) {
    requireEntries(parameter, values.size());
    Parameter& p = scene_.parameters[parameter];
    if (p.values.empty())
        throw Error(ErrorKind::Usage, p.name + " is kept in packed form and cannot change", "it was not named when the renderer was made");
    std::copy(values.begin(), values.end(), p.values.begin());
    if (places_[parameter] != gpu::kNone) {
        writeValues(parameter, values, 0);
        if (hasSecond_ && !second_.contains(parameter))
            writeValues(parameter, values, valueTexels_);
    }
    if (p.kind != SlotKind::Radiance) {
        uploadMaterials(false);
        if (hasSecond_)
            uploadMaterials(true);
    }
    if (emitsLight(p.kind))
        uploadLights();
}

void SceneBuffers::setSecond(std::uint32_t parameter, std::span<const float> values) {
    if (!hasSecond_)
        throw std::logic_error("these buffers hold one set of values");
    const std::vector<float>& base = scene_.parameters[parameter].values;
    if (values.empty())
        second_.erase(parameter);
    else {
        requireEntries(parameter, values.size());
        std::vector<float>& kept = second_[parameter];
        if (values.size() == scene_.parameters[parameter].channels)
            kept.assign(values.begin(), values.end());
    }
    if (places_[parameter] != gpu::kNone)
        writeValues(parameter, values.empty() ? std::span<const float>(base) : values, valueTexels_);
    uploadMaterials(true);
}

} // namespace cmpg

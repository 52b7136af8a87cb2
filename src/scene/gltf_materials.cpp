// Materials of a glTF scene: every slot of every material becomes a parameter.
#include "scene/gltf_textures.h"

#include <algorithm>
#include <cmath>
#include <glm/gtx/component_wise.hpp>

namespace cmpg {
namespace {

// Leaves room for the products of a float texture and the sums of a path.
constexpr float kBrightest = 1e30f;

// The channels of an image that make a slot, and how its codes become values.
struct SlotTexels {
    std::array<std::uint32_t, 3> channels{0, 1, 2}; // red 0 ... alpha 3
    bool color = false;                             // sRGB unless the file says otherwise
    glm::vec3 scale{1}, bias{0};
};

class MaterialLoader {
  public:
    explicit MaterialLoader(GltfLoad& load) : load_(load), images_(load) {}
    void add(const tinygltf::Material& source, std::uint32_t index);

  private:
    Parameter& slot(Material& material, SlotKind kind, std::uint32_t channels, glm::vec3 constant);
    void fill(Parameter& parameter, const TextureInfo& info, const SlotTexels& texels);
    void clampToRange(Parameter& parameter);
    void addAlphaTexture(Material& material, const TextureInfo& info);
    SurfaceModel modelOf(const tinygltf::Material& source, const std::string& name);

    GltfLoad& load_;
    ImageCache images_;
    UniqueNames names_;
};

// A constant parameter, to be replaced by texels if the slot has a texture.
Parameter& MaterialLoader::slot(Material& material, SlotKind kind, std::uint32_t channels, glm::vec3 constant) {
    material.parameters[std::size_t(kind)] = std::uint32_t(load_.scene.parameters.size());
    Parameter& p = load_.scene.parameters.emplace_back();
    p.name = material.name + "." + slotName(kind);
    p.kind = kind;
    p.channels = channels;
    p.values.assign(&constant[0], &constant[0] + channels);
    clampToRange(p);
    return p;
}

void MaterialLoader::clampToRange(Parameter& p) {
    if (p.kind == SlotKind::Normal) return; // normalised at look-up
    std::size_t outside = 0;
    for (float& v : p.values) {
        const float clamped = std::clamp(v, p.lowest(), std::min(p.highest(), kBrightest));
        outside += clamped != v;
        v = clamped;
    }
    if (outside) load_.warn(p.name + ": " + std::to_string(outside) + " values outside the range of the slot were clamped");
}

void MaterialLoader::fill(Parameter& p, const TextureInfo& info, const SlotTexels& texels) {
    const auto use = readTextureUse(load_, info);
    if (!use) return;
    const RawImage& image = images_.get(use->image);
    use->address(p);
    p.textured = true;
    p.width = image.width;
    p.height = image.height;
    const bool srgb = texels.color && !use->linear && !image.linear;
    std::array<std::uint32_t, 3> stored{};
    for (std::uint32_t c = 0; c < p.channels; ++c) {
        if (texels.channels[c] == 3 && !image.hasAlpha()) { // an image without alpha is opaque: the constant stays
            load_.warn(p.name + ": its texture has no alpha channel; its factor is used alone");
            p.textured = false;
            p.width = p.height = 1;
            return;
        }
        stored[c] = image.channel(texels.channels[c]);
    }
    p.values.clear();
    load_.addTextureBytes(p.entries() * (image.bytes.empty() ? sizeof(float) : 1), p.name);
    if (!image.bytes.empty()) {
        p.srgb = srgb;
        p.scale = texels.scale;
        p.bias = texels.bias;
        p.bytes.resize(p.entries());
        for (std::size_t i = 0; i < image.pixels(); ++i)
            for (std::uint32_t c = 0; c < p.channels; ++c) p.bytes[i * p.channels + c] = image.bytes[i * image.channels + stored[c]];
        return;
    }
    p.values.resize(p.entries());
    for (std::size_t i = 0; i < image.pixels(); ++i)
        for (std::uint32_t c = 0; c < p.channels; ++c) {
            const float code = image.values[i * image.channels + stored[c]];
            p.values[i * p.channels + c] = (srgb ? srgbDecode(code) : code) * texels.scale[int(c)] + texels.bias[int(c)];
        }
    clampToRange(p);
}

void MaterialLoader::addAlphaTexture(Material& material, const TextureInfo& info) {
    const auto use = readTextureUse(load_, info);
    if (!use) return;
    const RawImage& image = images_.get(use->image);
    if (!image.hasAlpha()) return;
    AlphaTexture alpha;
    use->address(alpha);
    alpha.width = image.width;
    alpha.height = image.height;
    load_.addTextureBytes(image.pixels(), material.name);
    alpha.alpha.resize(image.pixels());
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        const std::size_t from = i * image.channels + image.channel(3);
        const auto rounded = [](float v) { return std::uint8_t(std::lround(std::clamp(v, 0.0f, 1.0f) * 255)); };
        alpha.alpha[i] = image.bytes.empty() ? rounded(image.values[from]) : image.bytes[from];
    }
    material.alphaTexture = std::uint32_t(load_.scene.alphaTextures.size());
    load_.scene.alphaTextures.push_back(std::move(alpha));
}

// KHR_materials_transmission makes a boundary with KHR_materials_volume, and a thin pane without.
SurfaceModel MaterialLoader::modelOf(const tinygltf::Material& source, const std::string& name) {
    const tinygltf::Value& transmission = extension(source.extensions, "KHR_materials_transmission");
    const tinygltf::Value& volume = extension(source.extensions, "KHR_materials_volume");
    const float transmitted = real(member(transmission, "transmissionFactor"), 0);
    if (transmission.Has("transmissionTexture")) load_.ignored.insert("transmissionTexture of " + name);
    if (!(transmitted > 0)) return SurfaceModel::MetallicRoughness;
    const float ior = real(member(extension(source.extensions, "KHR_materials_ior"), "ior"), 1.5f);
    const bool opaque = transmitted < 0.5f || source.pbrMetallicRoughness.metallicFactor >= 0.5 || ior == 0;
    const bool partly = transmitted < 1 || (source.pbrMetallicRoughness.metallicFactor > 0 && source.pbrMetallicRoughness.metallicFactor < 1);
    if (partly) load_.warn(name + ": lets through a part of the light and scatters the rest; it is rendered " + (opaque ? "opaque" : "clear"));
    if (opaque) return SurfaceModel::MetallicRoughness;
    if (member(volume, "attenuationDistance").IsNumber()) load_.ignored.insert("attenuation in the volume of " + name);
    if (volume.Has("thicknessTexture")) load_.ignored.insert("thicknessTexture of " + name);
    return real(member(volume, "thicknessFactor"), 0) > 0 ? SurfaceModel::Dielectric : SurfaceModel::ThinDielectric;
}

void MaterialLoader::add(const tinygltf::Material& source, std::uint32_t index) {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    const tinygltf::Value& specular = extension(source.extensions, "KHR_materials_specular");
    const std::string ordinal = std::to_string(index);
    Material material;
    material.name = uniqueName(source.name.empty() ? "material" + ordinal : source.name, names_);

    const glm::vec4 baseColor = vec(pbr.baseColorFactor, glm::vec4(1));
    fill(slot(material, SlotKind::BaseColor, 3, glm::vec3(baseColor)), pbr.baseColorTexture,
         {.color = true, .scale = glm::clamp(glm::vec3(baseColor), 0.0f, 1.0f)});
    const auto roughness = float(pbr.roughnessFactor), metallic = float(pbr.metallicFactor);
    fill(slot(material, SlotKind::Roughness, 1, glm::vec3(roughness)), pbr.metallicRoughnessTexture,
         {.channels = {1}, .scale = glm::vec3(roughness)});
    fill(slot(material, SlotKind::Metallic, 1, glm::vec3(metallic)), pbr.metallicRoughnessTexture,
         {.channels = {2}, .scale = glm::vec3(metallic)});
    const float specularFactor = real(member(specular, "specularFactor"), 1);
    material.specularColor = glm::max(vec(member(specular, "specularColorFactor"), glm::vec3(1)), 0.0f);
    material.model = modelOf(source, material.name);
    if (material.model == SurfaceModel::MetallicRoughness) {
        fill(slot(material, SlotKind::Specular, 1, glm::vec3(specularFactor)), member(specular, "specularTexture"),
             {.channels = {3}, .scale = glm::vec3(specularFactor)});
    } else {
        slot(material, SlotKind::Specular, 3, specularFactor * material.specularColor);
        if (specular.Has("specularTexture")) load_.ignored.insert("specularTexture of " + material.name);
        const Parameter& rough = load_.scene.parameters[material.parameters[std::size_t(SlotKind::Roughness)]];
        material.roughnessIsAlpha = false;
        material.smooth = material.model == SurfaceModel::ThinDielectric || (!rough.textured && rough.values[0] < 0.03f); // alpha below 0.001
        if (material.model == SurfaceModel::ThinDielectric && (rough.textured || rough.values[0] >= 0.03f))
            load_.warn(material.name + ": a rough pane without KHR_materials_volume is rendered smooth");
    }
    const float strength = real(member(extension(source.extensions, "KHR_materials_emissive_strength"), "emissiveStrength"), 1);
    const glm::vec3 emission = glm::max(vec(source.emissiveFactor, glm::vec3(0)), 0.0f) * strength;
    if (!(glm::compMax(emission) <= kBrightest))
        load_.document.at("materials[" + ordinal + "].emissiveFactor").fail("times its strength is too large a number");
    fill(slot(material, SlotKind::Emission, 3, emission), source.emissiveTexture, {.color = true, .scale = emission});
    const auto s = float(source.normalTexture.scale);
    Parameter& normals = slot(material, SlotKind::Normal, 3, glm::vec3(0, 0, 1));
    fill(normals, source.normalTexture, {.scale = {2 * s, 2 * s, 2}, .bias = {-s, -s, -1}});
    material.hasNormalMap = normals.textured;

    material.ior = real(member(extension(source.extensions, "KHR_materials_ior"), "ior"), 1.5f);
    if (material.ior > 0 && material.ior < 1) { // 0 is the extension's way to say: reflects everything
        load_.warn(material.name + ": index of refraction " + std::to_string(material.ior) + " is below 1 and counts as 1");
        material.ior = 1;
    }
    if (specular.Has("specularColorTexture")) load_.ignored.insert("specularColorTexture of " + material.name);
    if (source.occlusionTexture.index >= 0) load_.ignored.insert("occlusion textures");

    if (source.alphaMode == "BLEND") load_.warn(material.name + ": alphaMode BLEND is rendered opaque");
    material.alphaMask = source.alphaMode == "MASK";
    if (material.alphaMask) {
        material.alphaCutoff = float(source.alphaCutoff);
        material.alphaFactor = baseColor.a;
        addAlphaTexture(material, pbr.baseColorTexture);
    }
    load_.scene.materials.push_back(std::move(material));
}

} // namespace

void loadMaterials(GltfLoad& load) {
    const std::vector<tinygltf::Material>& materials = load.model.materials;
    load.scene.parameters.reserve((materials.size() + 1) * kMaterialSlots + 1);
    MaterialLoader loader(load);
    for (std::uint32_t i = 0; i < materials.size(); ++i) loader.add(materials[i], i);
    if (usesDefaultMaterial(load)) loader.add({}, defaultMaterial(load));
}

} // namespace cmpg

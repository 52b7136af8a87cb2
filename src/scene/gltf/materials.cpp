// Materials of a glTF scene: every slot of every material becomes a parameter.
#include "scene/gltf/lobe_slots.h"
#include "scene/gltf/textures.h"

#include <algorithm>
#include <cmath>
#include <glm/gtx/component_wise.hpp>

namespace cmpg {
namespace {

class MaterialLoader {
  public:
    explicit MaterialLoader(GltfLoad& load) : load_(load), images_(load) {}
    void add(const tinygltf::Material& source, std::uint32_t index);
    void addGlass(); // after all others, whose numbers are the file's

  private:
    void fill(Parameter& parameter, const TextureInfo& info, const SlotTexels& texels);
    bool blendsGlass(const tinygltf::Material& source) const;
    SurfaceModel modelOf(const tinygltf::Material& source, const std::string& name);
    void makeGlass(Material& material);
    void addVolume(const tinygltf::Material& source, Material& material, bool cut);
    void addTransmission(const tinygltf::Material& source, Material& material);
    void addLobes(const tinygltf::Material& source, Material& material);
    void addDirection(const tinygltf::Value& anisotropy, Material& material);
    void addClearcoatNormals(const tinygltf::Material& source, Material& material);
    void chooseTexcoords(Material& material);

    GltfLoad& load_;
    ImageCache images_;
    UniqueNames names_;
    std::vector<std::pair<std::uint32_t, Material>> glass_; // second materials of blends, by the first
};

void MaterialLoader::fill(Parameter& p, const TextureInfo& info, const SlotTexels& texels) {
    const auto use = readTextureUse(load_, info);
    if (!use) return;
    SlotTexels codes = texels;
    codes.srgb = texels.srgb && !use->linear;
    load_.fillTexels(p, images_.get(use->image), *use, codes);
}

bool reflectsAll(const tinygltf::Material& source) { return real(member(extension(source.extensions, "KHR_materials_ior"), "ior"), 1.5f) == 0; }

float transmissionFactor(const tinygltf::Material& source) {
    return real(member(extension(source.extensions, "KHR_materials_transmission"), "transmissionFactor"), 0);
}

// It lets through a part of the light, or in some places, and scatters the rest.
bool MaterialLoader::blendsGlass(const tinygltf::Material& source) const {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    const float transmitted = transmissionFactor(source);
    if (!(transmitted > 0) || reflectsAll(source)) return false;
    const bool mayBeMetal = pbr.metallicFactor > 0;
    if (pbr.metallicFactor >= 1 && pbr.metallicRoughnessTexture.index < 0) return false;
    return transmitted < 1 || mayBeMetal || extension(source.extensions, "KHR_materials_transmission").Has("transmissionTexture");
}

// KHR_materials_transmission makes a boundary with KHR_materials_volume, and a thin pane without.
SurfaceModel MaterialLoader::modelOf(const tinygltf::Material& source, const std::string& name) {
    const tinygltf::Value& volume = extension(source.extensions, "KHR_materials_volume");
    if (!(transmissionFactor(source) > 0) || reflectsAll(source)) return SurfaceModel::MetallicRoughness;
    if (!blendsGlass(source) && source.pbrMetallicRoughness.metallicFactor > 0) return SurfaceModel::MetallicRoughness; // metals are opaque
    if (volume.Has("thicknessTexture")) load_.ignored.insert("thicknessTexture of " + name);
    return real(member(volume, "thicknessFactor"), 0) > 0 ? SurfaceModel::Dielectric : SurfaceModel::ThinDielectric;
}

// What a dielectric has beside its slots.
void MaterialLoader::makeGlass(Material& material) {
    const Parameter& rough = load_.scene.parameters[material.parameters[std::size_t(SlotKind::Roughness)]];
    material.roughnessIsAlpha = false;
    material.smooth = material.model == SurfaceModel::ThinDielectric || (!rough.textured && rough.values[0] < 0.03f); // alpha below 0.001
    if (material.model == SurfaceModel::ThinDielectric && (rough.textured || rough.values[0] >= 0.03f))
        load_.warn(material.name + ": a rough pane without KHR_materials_volume is rendered smooth");
}

// The material becomes a blend with glass, by the share of light that it lets through; metals let through none.
void MaterialLoader::addTransmission(const tinygltf::Material& source, Material& material) {
    const tinygltf::Value& transmission = extension(source.extensions, "KHR_materials_transmission");
    const float factor = transmissionFactor(source);
    Parameter metallic = load_.scene.parameters[material.parameters[std::size_t(SlotKind::Metallic)]];
    metallic.materialise();
    Parameter& weight = load_.addSlot(material, SlotKind::Weight, 1, glm::vec3(factor), "transmission");
    fill(weight, member(transmission, "transmissionTexture"), {.channels = {0}, .scale = glm::vec3(factor)});
    weight.materialise();
    if (!weight.textured && metallic.textured) {
        const std::string name = weight.name;
        weight = metallic;
        weight.name = name;
        weight.kind = SlotKind::Weight;
        weight.values.assign(metallic.values.size(), factor);
    }
    const bool alike = !metallic.textured || (metallic.width == weight.width && metallic.height == weight.height && metallic.uvTransform == weight.uvTransform &&
                                              metallic.texcoord == weight.texcoord);
    for (std::size_t i = 0; alike && i < weight.values.size(); ++i)
        weight.values[i] *= 1 - metallic.values[metallic.textured ? i : 0];
    const bool metal = std::any_of(metallic.values.begin(), metallic.values.end(), [](float m) { return m > 0; });
    if (metal && (!alike || !metallic.textured))
        load_.warn(material.name + ": is metal in part and lets light through in part; " + (alike ? "what it scatters is rendered with as much metal as all of it" : "its metal lets light through as well"));
    if (material.parameters[std::size_t(SlotKind::Clearcoat)] != kNoParameter)
        load_.warn(material.name + ": its clear coat covers what scatters light alone, not what lets it through");
    if (hasSheen(material))
        load_.warn(material.name + ": its sheen covers what scatters light alone, not what lets it through");
    if (material.specularColor != glm::vec3(1))
        load_.ignored.insert("specularColorFactor of " + material.name + " where it lets light through");
    Material glass = material;
    glass.name = material.name + ".glass";
    glass.model = modelOf(source, material.name);
    for (const SlotKind kind : {SlotKind::Clearcoat, SlotKind::ClearcoatRoughness, SlotKind::SheenRoughness, SlotKind::SheenColor})
        glass.parameters[std::size_t(kind)] = kNoParameter;
    glass.clearcoatNormals = ~0u;
    glass.alphaMask = glass.coverage = false;
    glass.alphaTexture = ~0u;
    makeGlass(glass);
    addVolume(source, glass, material.alphaMask);
    glass_.emplace_back(std::uint32_t(load_.scene.materials.size()), std::move(glass));
}

void MaterialLoader::addGlass() {
    for (auto& [first, glass] : glass_) {
        load_.scene.materials[first].blendWith = std::uint32_t(load_.scene.materials.size());
        load_.scene.materials.push_back(std::move(glass));
    }
}

// Of the color, per attenuationDistance: what is left of white light.
void MaterialLoader::addVolume(const tinygltf::Material& source, Material& material, bool cut) {
    const tinygltf::Value& volume = extension(source.extensions, "KHR_materials_volume");
    const float distance = real(member(volume, "attenuationDistance"), 0);
    if (!(distance > 0) || material.model != SurfaceModel::Dielectric)
        return;
    if (cut) {
        load_.ignored.insert("attenuation in the volume of " + material.name + ", which alpha cuts or covers in part");
        return;
    }
    constexpr float kDarkest = 1e-6f, kMost = 1e6f;
    const glm::vec3 color = glm::clamp(vec(member(volume, "attenuationColor"), glm::vec3(1)), kDarkest, 1.0f);
    material.absorption = glm::min(-glm::log(color) / distance, kMost);
}

void MaterialLoader::addLobes(const tinygltf::Material& source, Material& material) {
    for (const GltfLobeSlot& slot : kGltfLobeSlots) {
        const tinygltf::Value& lobe = extension(source.extensions, slot.extension);
        if (!lobe.IsObject())
            continue;
        const bool roughGlass = material.model == SurfaceModel::Dielectric && !isSmooth(material);
        if (material.model != SurfaceModel::MetallicRoughness && !(slot.kind == SlotKind::Anisotropy && roughGlass)) {
            load_.ignored.insert(std::string(slot.extension) + " of " + material.name + ", which is glass");
            continue;
        }
        const tinygltf::Value& given = member(lobe, slot.factor);
        if (slot.colour) {
            const glm::vec3 factor = vec(given, glm::vec3(slot.standard));
            fill(load_.addSlot(material, slot.kind, 3, factor), member(lobe, slot.texture), {.srgb = true, .scale = glm::clamp(factor, 0.0f, 1.0f)});
            continue;
        }
        const float factor = real(given, slot.standard);
        fill(load_.addSlot(material, slot.kind, 1, glm::vec3(factor)), member(lobe, slot.texture), {.channels = {slot.channel}, .scale = glm::vec3(factor)});
        if (slot.kind == SlotKind::Anisotropy)
            addDirection(lobe, material);
    }
}

// Of anisotropy, where it is not along the tangent.
void MaterialLoader::addDirection(const tinygltf::Value& anisotropy, Material& material) {
    const double rotation = number(member(anisotropy, "anisotropyRotation"), 0);
    if (const auto use = readTextureUse(load_, member(anisotropy, "anisotropyTexture")))
        load_.addDirectionTexture(material, images_.get(use->image), *use, rotation);
    else if (rotation != 0)
        load_.addDirectionTexture(material, RawImage{1, 1, 3, {}, {1, 0.5f, 0}, true}, {}, rotation);
}

// Without a texture of its own the coat lies on the surface as it is without its normal map. Where both have the same, the coat shares the surface's normals,
// which takes one look-up and has a derivative.
void MaterialLoader::addClearcoatNormals(const tinygltf::Material& source, Material& material) {
    const tinygltf::Value& info = member(extension(source.extensions, "KHR_materials_clearcoat"), "clearcoatNormalTexture");
    const float scale = real(member(info, "scale"), 1);
    const auto own = readTextureUse(load_, info);
    if (!own) {
        if (material.hasNormalMap)
            load_.addClearcoatNormals(material, RawImage{1, 1, 3, {}, {0.5f, 0.5f, 1}, true}, {}, 1);
        return;
    }
    if (material.hasNormalMap && scale == float(source.normalTexture.scale) && own == readTextureUse(load_, source.normalTexture))
        return;
    load_.addClearcoatNormals(material, images_.get(own->image), *own, scale);
}

// Until then textures have the numbers of the file. Vertices have two sets: 0 and 1 where these are enough, in place of which others come in.
void MaterialLoader::chooseTexcoords(Material& material) {
    std::vector<std::pair<std::uint32_t*, std::string>> uses;
    for (const std::uint32_t p : material.parameters)
        if (p != kNoParameter && load_.scene.parameters[p].textured)
            uses.emplace_back(&load_.scene.parameters[p].texcoord, load_.scene.parameters[p].name);
    if (material.alphaTexture != ~0u)
        uses.emplace_back(&load_.scene.alphaTextures[material.alphaTexture].texcoord, material.name + "'s alpha");
    for (const auto& [index, what] : {std::pair(material.anisotropyDirection, "'s direction of anisotropy"), std::pair(material.clearcoatNormals, "'s clear coat")})
        if (index != ~0u && load_.scene.directionTextures[index].directions.size() > 1) // one alone is the same everywhere
            uses.emplace_back(&load_.scene.directionTextures[index].texcoord, material.name + what);
    std::set<std::uint32_t> sets;
    for (const auto& [set, name] : uses)
        sets.insert(*set);
    std::array<std::uint32_t, 2>& kept = material.texcoordSets;
    for (const std::uint32_t set : sets) // ascending
        if (set > 1 && !sets.contains(kept[1]))
            kept[1] = set;
        else if (set > 1 && set != kept[1] && !sets.contains(kept[0]))
            kept[0] = set;
    for (const auto& [set, name] : uses) {
        if (*set != kept[0] && *set != kept[1])
            load_.warn(name + ": its texture is used with TEXCOORD_" + std::to_string(*set) + "; of a material two sets are read, and " + std::to_string(kept[0]) +
                       " is used instead");
        *set = *set == kept[1] ? 1 : 0;
    }
}

void MaterialLoader::add(const tinygltf::Material& source, std::uint32_t index) {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    const tinygltf::Value& specular = extension(source.extensions, "KHR_materials_specular");
    const std::string ordinal = std::to_string(index);
    if (source.extensions.contains("KHR_materials_unlit"))
        load_.document.at("materials[" + ordinal + "].extensions.KHR_materials_unlit")
            .fail("asks for a surface that shows its colour whatever the light", "such a surface scatters no light, so nothing can be rendered or recovered by it",
                  "export the material without it; an emissiveTexture shows a colour, too");
    Material material;
    material.name = uniqueName(source.name.empty() ? "material" + ordinal : source.name, names_);

    const glm::vec4 baseColor = vec(pbr.baseColorFactor, glm::vec4(1));
    fill(load_.addSlot(material, SlotKind::BaseColor, 3, glm::vec3(baseColor)), pbr.baseColorTexture,
         {.srgb = true, .scale = glm::clamp(glm::vec3(baseColor), 0.0f, 1.0f)});
    const auto roughness = float(pbr.roughnessFactor), metallic = float(pbr.metallicFactor);
    fill(load_.addSlot(material, SlotKind::Roughness, 1, glm::vec3(roughness)), pbr.metallicRoughnessTexture,
         {.channels = {1}, .scale = glm::vec3(roughness)});
    fill(load_.addSlot(material, SlotKind::Metallic, 1, glm::vec3(metallic)), pbr.metallicRoughnessTexture,
         {.channels = {2}, .scale = glm::vec3(metallic)});
    const float specularFactor = real(member(specular, "specularFactor"), 1);
    material.specularColor = glm::max(vec(member(specular, "specularColorFactor"), glm::vec3(1)), 0.0f);
    const bool blend = blendsGlass(source);
    if (!blend)
        material.model = modelOf(source, material.name);
    if (material.model == SurfaceModel::MetallicRoughness) {
        fill(load_.addSlot(material, SlotKind::Specular, 1, glm::vec3(specularFactor)), member(specular, "specularTexture"),
             {.channels = {3}, .scale = glm::vec3(specularFactor)});
    } else {
        const glm::vec3 reflected = specularFactor * material.specularColor;
        fill(load_.addSlot(material, SlotKind::Specular, 3, reflected), member(specular, "specularColorTexture"),
             {.srgb = true, .scale = glm::clamp(reflected, 0.0f, 1.0f)});
        if (specular.Has("specularTexture")) load_.ignored.insert("specularTexture of " + material.name);
        makeGlass(material);
    }
    const float strength = real(member(extension(source.extensions, "KHR_materials_emissive_strength"), "emissiveStrength"), 1);
    const glm::vec3 emission = glm::max(vec(source.emissiveFactor, glm::vec3(0)), 0.0f) * strength;
    if (!(glm::compMax(emission) <= kBrightest))
        load_.document.at("materials[" + ordinal + "].emissiveFactor").fail("times its strength is too large a number");
    fill(load_.addSlot(material, SlotKind::Emission, 3, emission), source.emissiveTexture, {.srgb = true, .scale = emission});
    const auto s = float(source.normalTexture.scale);
    Parameter& normals = load_.addSlot(material, SlotKind::Normal, 3, glm::vec3(0, 0, 1));
    fill(normals, source.normalTexture, {.scale = {2 * s, 2 * s, 2}, .bias = {-s, -s, -1}});
    material.hasNormalMap = normals.textured;
    addLobes(source, material);
    if (material.parameters[std::size_t(SlotKind::Clearcoat)] != kNoParameter) {
        addClearcoatNormals(source, material);
        if (glm::compMax(emission) > 0)
            load_.warn(material.name + ": its emission shines through the clear coat as if there were none");
    }

    material.ior = real(member(extension(source.extensions, "KHR_materials_ior"), "ior"), 1.5f);
    if (material.ior > 0 && material.ior < 1) { // 0 is the extension's way to say: reflects everything
        load_.warn(material.name + ": index of refraction " + std::to_string(material.ior) + " is below 1 and taken for 1");
        material.ior = 1;
    }
    if (specular.Has("specularColorTexture") && material.model == SurfaceModel::MetallicRoughness) load_.ignored.insert("specularColorTexture of " + material.name);
    if (source.occlusionTexture.index >= 0) load_.ignored.insert("occlusion textures");

    material.coverage = source.alphaMode == "BLEND";
    material.alphaMask = material.coverage || source.alphaMode == "MASK";
    if (material.alphaMask) {
        material.alphaCutoff = float(source.alphaCutoff);
        material.alphaFactor = baseColor.a;
        if (const auto use = readTextureUse(load_, pbr.baseColorTexture)) load_.addAlphaTexture(material, images_.get(use->image), *use);
    }
    addVolume(source, material, material.alphaMask);
    if (blend)
        addTransmission(source, material);
    chooseTexcoords(material);
    load_.scene.materials.push_back(std::move(material));
}

} // namespace

void loadMaterials(GltfLoad& load) {
    const std::vector<tinygltf::Material>& materials = load.model.materials;
    load.scene.parameters.reserve((materials.size() + 1) * kMaterialSlots + 1);
    MaterialLoader loader(load);
    for (std::uint32_t i = 0; i < materials.size(); ++i) loader.add(materials[i], i);
    if (usesDefaultMaterial(load)) loader.add({}, defaultMaterial(load));
    loader.addGlass();
}

} // namespace cmpg

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

  private:
    void fill(Parameter& parameter, const TextureInfo& info, const SlotTexels& texels);
    SurfaceModel modelOf(const tinygltf::Material& source, const std::string& name);
    void addVolume(const tinygltf::Material& source, Material& material);
    void addLobes(const tinygltf::Material& source, Material& material);

    GltfLoad& load_;
    ImageCache images_;
    UniqueNames names_;
};

void MaterialLoader::fill(Parameter& p, const TextureInfo& info, const SlotTexels& texels) {
    const auto use = readTextureUse(load_, info);
    if (!use) return;
    SlotTexels codes = texels;
    codes.srgb = texels.srgb && !use->linear;
    load_.fillTexels(p, images_.get(use->image), *use, codes);
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
    if (volume.Has("thicknessTexture")) load_.ignored.insert("thicknessTexture of " + name);
    return real(member(volume, "thicknessFactor"), 0) > 0 ? SurfaceModel::Dielectric : SurfaceModel::ThinDielectric;
}

// Of the color, per attenuationDistance: what is left of white light.
void MaterialLoader::addVolume(const tinygltf::Material& source, Material& material) {
    const tinygltf::Value& volume = extension(source.extensions, "KHR_materials_volume");
    const float distance = real(member(volume, "attenuationDistance"), 0);
    if (!(distance > 0) || material.model != SurfaceModel::Dielectric)
        return;
    if (material.alphaMask) {
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
        if (material.model != SurfaceModel::MetallicRoughness) {
            load_.ignored.insert(std::string(slot.extension) + " of " + material.name + ", which is glass");
            continue;
        }
        const float factor = real(member(lobe, slot.factor), slot.standard);
        fill(load_.addSlot(material, slot.kind, 1, glm::vec3(factor)), member(lobe, slot.texture), {.channels = {slot.channel}, .scale = glm::vec3(factor)});
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
    material.model = modelOf(source, material.name);
    if (material.model == SurfaceModel::MetallicRoughness) {
        fill(load_.addSlot(material, SlotKind::Specular, 1, glm::vec3(specularFactor)), member(specular, "specularTexture"),
             {.channels = {3}, .scale = glm::vec3(specularFactor)});
    } else {
        load_.addSlot(material, SlotKind::Specular, 3, specularFactor * material.specularColor);
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
    fill(load_.addSlot(material, SlotKind::Emission, 3, emission), source.emissiveTexture, {.srgb = true, .scale = emission});
    const auto s = float(source.normalTexture.scale);
    Parameter& normals = load_.addSlot(material, SlotKind::Normal, 3, glm::vec3(0, 0, 1));
    fill(normals, source.normalTexture, {.scale = {2 * s, 2 * s, 2}, .bias = {-s, -s, -1}});
    material.hasNormalMap = normals.textured;
    addLobes(source, material);
    if (material.parameters[std::size_t(SlotKind::Clearcoat)] != kNoParameter) {
        const tinygltf::Value& coat = extension(source.extensions, "KHR_materials_clearcoat");
        if (coat.Has("clearcoatNormalTexture") || material.hasNormalMap)
            load_.warn(material.name + ": its clear coat has the normals of what is below it");
        if (glm::compMax(emission) > 0)
            load_.warn(material.name + ": its emission shines through the clear coat as if there were none");
    }

    material.ior = real(member(extension(source.extensions, "KHR_materials_ior"), "ior"), 1.5f);
    if (material.ior > 0 && material.ior < 1) { // 0 is the extension's way to say: reflects everything
        load_.warn(material.name + ": index of refraction " + std::to_string(material.ior) + " is below 1 and counts as 1");
        material.ior = 1;
    }
    if (specular.Has("specularColorTexture")) load_.ignored.insert("specularColorTexture of " + material.name);
    if (source.occlusionTexture.index >= 0) load_.ignored.insert("occlusion textures");

    material.coverage = source.alphaMode == "BLEND";
    material.alphaMask = material.coverage || source.alphaMode == "MASK";
    if (material.alphaMask) {
        material.alphaCutoff = float(source.alphaCutoff);
        material.alphaFactor = baseColor.a;
        if (const auto use = readTextureUse(load_, pbr.baseColorTexture)) load_.addAlphaTexture(material, images_.get(use->image), *use);
    }
    addVolume(source, material);
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

// Materials of a glTF scene: every slot of every material becomes a parameter.
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

void MaterialLoader::add(const tinygltf::Material& source, std::uint32_t index) {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    const tinygltf::Value& specular = extension(source.extensions, "KHR_materials_specular");
    const std::string ordinal = std::to_string(index);
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
    fill(load_.addSlot(material, SlotKind::Specular, 1, glm::vec3(specularFactor)), member(specular, "specularTexture"),
         {.channels = {3}, .scale = glm::vec3(specularFactor)});
    const float strength = real(member(extension(source.extensions, "KHR_materials_emissive_strength"), "emissiveStrength"), 1);
    const glm::vec3 emission = glm::max(vec(source.emissiveFactor, glm::vec3(0)), 0.0f) * strength;
    if (!(glm::compMax(emission) <= kBrightest))
        load_.document.at("materials[" + ordinal + "].emissiveFactor").fail("times its strength is too large a number");
    fill(load_.addSlot(material, SlotKind::Emission, 3, emission), source.emissiveTexture, {.srgb = true, .scale = emission});
    const auto s = float(source.normalTexture.scale);
    Parameter& normals = load_.addSlot(material, SlotKind::Normal, 3, glm::vec3(0, 0, 1));
    fill(normals, source.normalTexture, {.scale = {2 * s, 2 * s, 2}, .bias = {-s, -s, -1}});
    material.hasNormalMap = normals.textured;

    material.ior = real(member(extension(source.extensions, "KHR_materials_ior"), "ior"), 1.5f);
    if (material.ior > 0 && material.ior < 1) { // 0 is the extension's way to say: reflects everything
        load_.warn(material.name + ": index of refraction " + std::to_string(material.ior) + " is below 1 and counts as 1");
        material.ior = 1;
    }
    material.specularColor = glm::max(vec(member(specular, "specularColorFactor"), glm::vec3(1)), 0.0f);
    if (specular.Has("specularColorTexture")) load_.ignored.insert("specularColorTexture of " + material.name);
    if (source.occlusionTexture.index >= 0) load_.ignored.insert("occlusion textures");

    if (source.alphaMode == "BLEND") load_.warn(material.name + ": alphaMode BLEND is rendered opaque");
    material.alphaMask = source.alphaMode == "MASK";
    if (material.alphaMask) {
        material.alphaCutoff = float(source.alphaCutoff);
        material.alphaFactor = baseColor.a;
        if (const auto use = readTextureUse(load_, pbr.baseColorTexture)) load_.addAlphaTexture(material, images_.get(use->image), *use);
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

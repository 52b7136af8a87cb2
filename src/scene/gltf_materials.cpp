// Materials of a glTF scene: every slot of every material becomes a parameter.
#include "scene/gltf_textures.h"

#include <algorithm>
#include <cmath>
#include <glm/gtx/component_wise.hpp>
#include <limits>

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
    void add(const JsonView& json, std::string name);

  private:
    Parameter& slot(Material& material, SlotKind kind, std::uint32_t channels, glm::vec3 constant);
    void fill(Parameter& parameter, const JsonView& info, const SlotTexels& texels);
    void clampToRange(Parameter& parameter);
    void addAlphaTexture(Material& material, const JsonView& info);

    GltfLoad& load_;
    ImageCache images_;
    std::set<std::string> names_;
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

void MaterialLoader::fill(Parameter& p, const JsonView& info, const SlotTexels& texels) {
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
            load_.warn(info.place() + " has no alpha channel; its factor is used alone");
            p.textured = false;
            p.width = p.height = 1;
            return;
        }
        stored[c] = image.channel(texels.channels[c]);
    }
    p.values.clear();
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

void MaterialLoader::addAlphaTexture(Material& material, const JsonView& info) {
    const auto use = readTextureUse(load_, info);
    if (!use) return;
    const RawImage& image = images_.get(use->image);
    if (!image.hasAlpha()) return;
    AlphaTexture alpha;
    use->address(alpha);
    alpha.width = image.width;
    alpha.height = image.height;
    alpha.alpha.resize(image.pixels());
    for (std::size_t i = 0; i < image.pixels(); ++i) {
        const std::size_t from = i * image.channels + image.channel(3);
        const auto rounded = [](float v) { return std::uint8_t(std::lround(std::clamp(v, 0.0f, 1.0f) * 255)); };
        alpha.alpha[i] = image.bytes.empty() ? rounded(image.values[from]) : image.bytes[from];
    }
    material.alphaTexture = std::uint32_t(load_.scene.alphaTextures.size());
    load_.scene.alphaTextures.push_back(std::move(alpha));
}

void MaterialLoader::add(const JsonView& json, std::string name) {
    constexpr float kAny = std::numeric_limits<float>::max();
    Material material;
    material.name = uniqueName(json["name"].string(name), names_);
    const JsonView pbr = json["pbrMetallicRoughness"], extensions = json["extensions"];
    const JsonView specular = extensions["KHR_materials_specular"];

    const glm::vec4 baseColor = pbr["baseColorFactor"].vec(glm::vec4(1));
    fill(slot(material, SlotKind::BaseColor, 3, glm::vec3(baseColor)), pbr["baseColorTexture"],
         {.color = true, .scale = glm::clamp(glm::vec3(baseColor), 0.0f, 1.0f)});
    const float roughness = pbr["roughnessFactor"].real(1, 0, 1), metallic = pbr["metallicFactor"].real(1, 0, 1);
    fill(slot(material, SlotKind::Roughness, 1, glm::vec3(roughness)), pbr["metallicRoughnessTexture"],
         {.channels = {1}, .scale = glm::vec3(roughness)});
    fill(slot(material, SlotKind::Metallic, 1, glm::vec3(metallic)), pbr["metallicRoughnessTexture"],
         {.channels = {2}, .scale = glm::vec3(metallic)});
    const float specularFactor = specular["specularFactor"].real(1, 0, 1);
    fill(slot(material, SlotKind::Specular, 1, glm::vec3(specularFactor)), specular["specularTexture"],
         {.channels = {3}, .scale = glm::vec3(specularFactor)});
    const float strength = extensions["KHR_materials_emissive_strength"]["emissiveStrength"].real(1, 0, kAny);
    const glm::vec3 emission = glm::max(json["emissiveFactor"].vec(glm::vec3(0)), 0.0f) * strength;
    if (!(glm::compMax(emission) <= kBrightest)) json["emissiveFactor"].fail("times its strength is too large a number");
    fill(slot(material, SlotKind::Emission, 3, emission), json["emissiveTexture"], {.color = true, .scale = emission});
    const JsonView normal = json["normalTexture"];
    const float s = normal["scale"].real(1, -1e6f, 1e6f);
    Parameter& normals = slot(material, SlotKind::Normal, 3, glm::vec3(0, 0, 1));
    fill(normals, normal, {.scale = {2 * s, 2 * s, 2}, .bias = {-s, -s, -1}});
    material.hasNormalMap = normals.textured;

    material.ior = extensions["KHR_materials_ior"]["ior"].real(1.5f, 0, kAny);
    if (material.ior > 0 && material.ior < 1) { // 0 is the extension's way to say: reflects everything
        load_.warn(material.name + ": index of refraction " + std::to_string(material.ior) + " is below 1 and counts as 1");
        material.ior = 1;
    }
    material.specularColor = glm::max(specular["specularColorFactor"].vec(glm::vec3(1)), 0.0f);
    if (specular["specularColorTexture"].exists()) load_.ignored.insert("specularColorTexture of " + material.name);
    if (json["occlusionTexture"].exists()) load_.ignored.insert("occlusion textures");

    const std::string alphaMode = json["alphaMode"].string("OPAQUE");
    if (alphaMode == "BLEND") {
        load_.warn(material.name + ": alphaMode BLEND is rendered opaque");
    } else if (alphaMode == "MASK") {
        material.alphaMask = true;
        material.alphaCutoff = json["alphaCutoff"].real(0.5f, 0, kAny);
        material.alphaFactor = baseColor.a;
        addAlphaTexture(material, pbr["baseColorTexture"]);
    } else if (alphaMode != "OPAQUE") {
        json["alphaMode"].fail("is \"" + alphaMode + "\"; glTF has OPAQUE, MASK and BLEND");
    }
    load_.scene.materials.push_back(std::move(material));
}

} // namespace

void loadMaterials(GltfLoad& load) {
    const JsonView materials = load.root["materials"];
    load.scene.parameters.reserve((std::size_t(materials.size()) + 1) * kMaterialSlots + 1);
    MaterialLoader loader(load);
    for (std::uint32_t i = 0; i < materials.size(); ++i) loader.add(materials.at(i), "material" + std::to_string(i));
    if (!usesDefaultMaterial(load)) return;
    loader.add(JsonView(nullptr, load.document.name(), "the default material"), "material" + std::to_string(defaultMaterial(load)));
}

} // namespace cmpg

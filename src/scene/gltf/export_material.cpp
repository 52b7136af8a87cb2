// Puts parameter values back into a glTF material: 8-bit textures whose factors are 1, or factors alone.
#include "base/error.h"
#include "base/log.h"
#include "scene/gltf/export.h"
#include "scene/gltf/lobe_slots.h"
#include "scene/image_decode.h"
#include "scene/resample.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

std::uint8_t code(float v) { return std::uint8_t(std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f)); }
std::uint8_t srgbCode(float v) { return code(srgbEncode(std::clamp(v, 0.0f, 1.0f))); }

class MaterialExporter {
  public:
    MaterialExporter(Json& root, const GltfDocument& source, const Scene& scene, std::uint32_t index, ExportFolder& folder)
        : root_(root), json_(root["materials"][index]), source_(source), scene_(scene), material_(scene.materials[index]),
          folder_(folder), metallic_(values(SlotKind::Metallic)) {}

    void baseColor();
    void metallicRoughness();
    void specular();
    void emission();
    void normal();
    void lobe(const GltfLobeSlot& slot);
    void lobeColour(const GltfLobeSlot& slot, Json& json, const Parameter& p);
    void transmission();
    // Whether the written metallic values stand where those of the scene do.
    bool keepsMetallicTexels(const Parameter& before) const;
    void dropTransmission();

  private:
    Parameter values(SlotKind kind) const {
        Parameter p = scene_.parameters[material_.parameters[std::size_t(kind)]];
        p.materialise();
        return p;
    }
    Json& extension(const char* name);
    // Takes away a texture whose image is not read, and so has no part in the values: other programs, which may read it, would multiply them by it.
    void dropUnread(Json& holder, const char* key) const;
    // Lets `holder`[key] use a new image; sampler, texture coordinates and their transform stay.
    void setTexture(Json& holder, const char* key, const std::string& name, const Parameter& size, const Bytes& pixels, int channels);
    std::uint32_t imageOf(const Json& info) const { return root_["textures"][info["index"].get<std::size_t>()]["source"].get<std::uint32_t>(); }
    void keepDirections(const Json& holder, const char* key, Bytes& pixels);
    std::vector<std::uint8_t> originalAlpha(const Json& holder, const char* key, const Parameter& p);
    void writeLobe(const GltfLobeSlot& slot, const Parameter& p);
    bool metallicIsAlike(const Parameter& weight) const;

    Json& root_;
    Json& json_;
    const GltfDocument& source_;
    const Scene& scene_;
    const Material& material_;
    ExportFolder& folder_;
    Parameter metallic_; // as the written file has it
};

Json& MaterialExporter::extension(const char* name) {
    Json& used = root_["extensionsUsed"];
    if (std::find(used.begin(), used.end(), name) == used.end()) used.push_back(name);
    return json_["extensions"][name];
}

void MaterialExporter::setTexture(Json& holder, const char* key, const std::string& name, const Parameter& size, const Bytes& pixels,
                                  int channels) {
    Json& info = holder[key];
    Json texture = Json::object();
    if (info.contains("index")) {
        const Json& old = root_["textures"][info["index"].get<std::size_t>()];
        if (old.contains("sampler")) texture["sampler"] = old["sampler"];
    }
    const std::string uri =
        uriOf(folder_.add("textures/" + fileName(name), ".png", encodePng(pixels, int(size.width), int(size.height), channels)));
    root_["images"].push_back({{"uri", uri}, {"name", name}});
    texture["source"] = root_["images"].size() - 1;
    root_["textures"].push_back(std::move(texture));
    info["index"] = root_["textures"].size() - 1;
    // The set that it is looked up by here, where the file names more sets than are read.
    const std::uint32_t set = material_.texcoordSets[size.texcoord];
    if (info.contains("extensions") && info["extensions"].contains("KHR_texture_transform") && info["extensions"]["KHR_texture_transform"].contains("texCoord"))
        info["extensions"]["KHR_texture_transform"]["texCoord"] = set;
    else if (set != 0 || info.contains("texCoord"))
        info["texCoord"] = set;
}

void MaterialExporter::dropUnread(Json& holder, const char* key) const {
    if (holder.contains(key) && !root_["textures"][holder[key]["index"].get<std::size_t>()].contains("source"))
        holder.erase(key);
}

// Alpha codes of the texture that `holder` has under `key`, of the parameter's size, or none if there is none with alpha.
std::vector<std::uint8_t> MaterialExporter::originalAlpha(const Json& holder, const char* key, const Parameter& p) {
    if (!holder.contains(key)) return {}; // a constant that became a texture
    const RawImage raw = decodeImage(source_.imageBytes(imageOf(holder[key])), source_.name());
    if (!raw.hasAlpha()) return {};
    std::vector<float> alpha(raw.pixels());
    for (std::size_t i = 0; i < alpha.size(); ++i) {
        const std::size_t from = i * raw.channels + raw.channel(3);
        alpha[i] = raw.bytes.empty() ? raw.values[from] : float(raw.bytes[from]) / 255.0f;
    }
    std::vector<std::uint8_t> codes;
    for (const float value : resampled(alpha, 1, {raw.width, raw.height}, {p.width, p.height}, p.wrapU, p.wrapV)) codes.push_back(code(value));
    return codes;
}

// Puts red and green of the texture that `holder` has under `key` into those of RGB pixels; without one, the tangent.
void MaterialExporter::keepDirections(const Json& holder, const char* key, Bytes& pixels) {
    if (!holder.contains(key)) {
        for (std::size_t i = 0; i < pixels.size(); i += 3) {
            pixels[i] = 255;
            pixels[i + 1] = 128;
        }
        return;
    }
    const RawImage raw = decodeImage(source_.imageBytes(imageOf(holder[key])), source_.name());
    for (std::size_t i = 0; i < std::min(raw.pixels(), pixels.size() / 3); ++i)
        for (std::uint32_t c = 0; c < 2; ++c) {
            const std::size_t from = i * raw.channels + raw.channel(c);
            pixels[3 * i + c] = raw.bytes.empty() ? code(raw.values[from]) : raw.bytes[from];
        }
}

void MaterialExporter::baseColor() {
    const Parameter p = values(SlotKind::BaseColor);
    Json& pbr = json_["pbrMetallicRoughness"];
    dropUnread(pbr, "baseColorTexture");
    const double alphaFactor = pbr.contains("baseColorFactor") ? pbr["baseColorFactor"][3].get<double>() : 1.0;
    if (!p.textured) {
        pbr["baseColorFactor"] = {p.values[0], p.values[1], p.values[2], alphaFactor};
        return;
    }
    const std::vector<std::uint8_t> alpha = originalAlpha(pbr, "baseColorTexture", p);
    Bytes pixels;
    for (std::size_t i = 0; i < std::size_t(p.width) * p.height; ++i) {
        for (std::size_t c = 0; c < 3; ++c) pixels.push_back(srgbCode(p.values[i * 3 + c]));
        if (!alpha.empty()) pixels.push_back(alpha[i]);
    }
    setTexture(pbr, "baseColorTexture", p.name, p, pixels, alpha.empty() ? 3 : 4);
    pbr["baseColorFactor"] = {1, 1, 1, alphaFactor};
}

void MaterialExporter::metallicRoughness() {
    Parameter rough = values(SlotKind::Roughness);
    Parameter metal = values(SlotKind::Metallic);
    if (!readsSlot(material_, SlotKind::Metallic)) // glass, which a metallic share would make a metal
        metal.values.assign(metal.values.size(), 0.0f);
    Json& pbr = json_["pbrMetallicRoughness"];
    dropUnread(pbr, "metallicRoughnessTexture");
    if (!rough.textured && !metal.textured) {
        pbr["roughnessFactor"] = rough.values[0];
        pbr["metallicFactor"] = metal.values[0];
        metallic_ = metal;
        return;
    }
    const glm::uvec2 size(std::max(rough.width, metal.width), std::max(rough.height, metal.height)); // one image has both
    for (Parameter* p : {&rough, &metal}) {
        p->values = resampled(p->values, 1, {p->width, p->height}, size, p->wrapU, p->wrapV);
        p->width = size.x;
        p->height = size.y;
    }
    Bytes pixels; // red is free: occlusion, which may share the original image, keeps using that
    for (std::size_t i = 0; i < rough.values.size(); ++i) pixels.insert(pixels.end(), {255, code(rough.values[i]), code(metal.values[i])});
    setTexture(pbr, "metallicRoughnessTexture", material_.name + ".metallicRoughness", rough, pixels, 3);
    pbr["roughnessFactor"] = pbr["metallicFactor"] = 1;
    metallic_ = metal;
    for (float& v : metallic_.values) v = float(code(v)) / 255.0f;
    if (!metal.textured) { // it has the place of the roughness now
        metallic_.textured = true;
        metallic_.texcoord = rough.texcoord;
        metallic_.uvTransform = rough.uvTransform;
    }
}

void MaterialExporter::specular() {
    const Parameter p = values(SlotKind::Specular);
    Json& json = extension("KHR_materials_specular");
    dropUnread(json, p.channels == 3 ? "specularColorTexture" : "specularTexture");
    if (p.channels == 3) { // what a dielectric reflects
        json["specularFactor"] = 1;
        json["specularColorFactor"] = p.textured ? Json({1, 1, 1}) : Json({p.values[0], p.values[1], p.values[2]});
        if (!p.textured) return;
        Bytes pixels;
        for (const float v : p.values) pixels.push_back(srgbCode(v));
        setTexture(json, "specularColorTexture", p.name, p, pixels, 3);
        return;
    }
    json["specularFactor"] = p.textured ? 1.0f : p.values[0];
    if (!p.textured) return;
    Bytes pixels;
    for (const float v : p.values) pixels.insert(pixels.end(), {255, 255, 255, code(v)});
    setTexture(json, "specularTexture", p.name, p, pixels, 4);
}

// emissiveFactor and the texture stay within [0,1]; what is brighter goes into the strength.
void MaterialExporter::emission() {
    const Parameter p = values(SlotKind::Emission);
    dropUnread(json_, "emissiveTexture");
    const float brightest = *std::max_element(p.values.begin(), p.values.end());
    const float strength = std::max(brightest, 1.0f);
    if (strength > 1)
        extension("KHR_materials_emissive_strength")["emissiveStrength"] = strength;
    else if (json_.contains("extensions"))
        json_["extensions"].erase("KHR_materials_emissive_strength");
    if (!p.textured) {
        json_["emissiveFactor"] = {p.values[0] / strength, p.values[1] / strength, p.values[2] / strength};
        return;
    }
    const float factor = brightest > 0 ? std::min(brightest, 1.0f) : 1.0f; // dark textures use all codes too
    Bytes pixels;
    for (const float v : p.values) pixels.push_back(srgbCode(v / (factor * strength)));
    setTexture(json_, "emissiveTexture", p.name, p, pixels, 3);
    json_["emissiveFactor"] = {factor, factor, factor};
}

void MaterialExporter::normal() {
    const Parameter p = values(SlotKind::Normal);
    dropUnread(json_, "normalTexture");
    if (!p.textured && p.values == std::vector<float>{0, 0, 1}) return;
    Bytes pixels;
    for (std::size_t i = 0; i < p.values.size(); i += 3) {
        glm::vec3 n(p.values[i], p.values[i + 1], p.values[i + 2]);
        const float largest = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
        if (largest > 1) n = glm::normalize(n); // a scale above 1 was folded in
        for (int c = 0; c < 3; ++c) pixels.push_back(code(n[c] * 0.5f + 0.5f));
    }
    setTexture(json_, "normalTexture", p.name, p, pixels, 3);
    json_["normalTexture"].erase("scale");
    if (material_.parameters[std::size_t(SlotKind::Clearcoat)] != kNoParameter && !hasClearcoatNormals(material_)) // the coat shares them
        extension("KHR_materials_clearcoat")["clearcoatNormalTexture"] = json_["normalTexture"];
}

// The image has the value in all channels, so whichever the slot is read from; but of anisotropy, whose directions stay.
void MaterialExporter::lobe(const GltfLobeSlot& slot) { writeLobe(slot, values(slot.kind)); }

void MaterialExporter::writeLobe(const GltfLobeSlot& slot, const Parameter& p) {
    Json& json = extension(slot.extension);
    dropUnread(json, slot.texture);
    if (slot.colour)
        return lobeColour(slot, json, p);
    json[slot.factor] = p.textured ? 1.0f : p.values[0];
    if (!p.textured)
        return;
    Bytes pixels;
    const int channels = slot.channel == 3 ? 4 : 3;
    for (const float v : p.values) pixels.insert(pixels.end(), std::size_t(channels), code(v));
    if (slot.kind == SlotKind::Anisotropy) keepDirections(json, slot.texture, pixels);
    setTexture(json, slot.texture, p.name, p, pixels, channels);
}

void MaterialExporter::lobeColour(const GltfLobeSlot& slot, Json& json, const Parameter& p) {
    if (!p.textured) {
        json[slot.factor] = {p.values[0], p.values[1], p.values[2]};
        return;
    }
    Bytes pixels;
    for (const float v : p.values) pixels.push_back(srgbCode(v));
    setTexture(json, slot.texture, p.name, p, pixels, 3);
    json[slot.factor] = {1, 1, 1};
}

bool MaterialExporter::keepsMetallicTexels(const Parameter& before) const {
    return metallic_.textured == before.textured && metallic_.width == before.width && metallic_.height == before.height;
}

// Of a metal, which is opaque whatever the file has here: less of a metal would let light through by it.
void MaterialExporter::dropTransmission() {
    if (json_.contains("extensions")) json_["extensions"].erase("KHR_materials_transmission");
}

// Whether texels of both belong together, so that the reader multiplies the weight by what is no metal.
bool MaterialExporter::metallicIsAlike(const Parameter& weight) const {
    return !metallic_.textured || (metallic_.width == weight.width && metallic_.height == weight.height && metallic_.uvTransform == weight.uvTransform &&
                                   metallic_.texcoord == weight.texcoord);
}

// The weight is what the factor leaves of it where there is metal. By the texture coordinates of the metallic values, if it was these that made a texture of it.
void MaterialExporter::transmission() {
    const GltfLobeSlot slot{SlotKind::Weight, "KHR_materials_transmission", "transmissionFactor", "transmissionTexture", 0, 0};
    Json& json = extension(slot.extension);
    dropUnread(json, slot.texture);
    Parameter weight = values(SlotKind::Weight);
    if (!weight.textured && metallic_.textured) { // as the reader will have it
        const float constant = weight.values[0];
        const std::string name = weight.name;
        weight = metallic_;
        weight.name = name;
        weight.values.assign(metallic_.values.size(), constant);
    }
    const Json& pbr = json_["pbrMetallicRoughness"];
    if (weight.textured && metallic_.textured && !json.contains(slot.texture) && pbr.contains("metallicRoughnessTexture"))
        json[slot.texture] = pbr["metallicRoughnessTexture"];
    bool cut = false;
    for (std::size_t i = 0; metallicIsAlike(weight) && i < weight.values.size(); ++i) {
        const float rest = 1 - metallic_.values[metallic_.textured ? i : 0], wanted = weight.values[i];
        weight.values[i] = rest > 0 ? std::min(wanted / rest, 1.0f) : 0.0f;
        cut |= wanted > rest + 0.5f / 255.0f;
    }
    if (cut)
        logWarn(weight.name + ": where it and metallic are above 1 in sum the written scene lets less light through, since glTF's metal lets none; parameters/ has all");
    writeLobe(slot, weight);
}

} // namespace

void exportMaterial(Json& root, const GltfDocument& source, const Scene& scene, std::uint32_t index, const std::set<SlotKind>& changed,
                    ExportFolder& folder) {
    MaterialExporter exporter(root, source, scene, index, folder);
    if (changed.contains(SlotKind::BaseColor)) exporter.baseColor();
    if (changed.contains(SlotKind::Roughness) || changed.contains(SlotKind::Metallic)) exporter.metallicRoughness();
    if (changed.contains(SlotKind::Specular)) exporter.specular();
    if (changed.contains(SlotKind::Emission)) exporter.emission();
    if (changed.contains(SlotKind::Normal)) exporter.normal();
    const Material& material = scene.materials[index];
    const std::uint32_t metallic = material.parameters[std::size_t(SlotKind::Metallic)];
    const bool blend = material.parameters[std::size_t(SlotKind::Weight)] != kNoParameter;
    if (changed.contains(SlotKind::Weight) || (blend && (changed.contains(SlotKind::Metallic) || !exporter.keepsMetallicTexels(scene.parameters[metallic]))))
        exporter.transmission();
    else if (!blend && material.model == SurfaceModel::MetallicRoughness && changed.contains(SlotKind::Metallic))
        exporter.dropTransmission();
    for (const GltfLobeSlot& slot : kGltfLobeSlots)
        if (changed.contains(slot.kind)) exporter.lobe(slot);
}

} // namespace cmpg

// What stands between a glTF file and tinygltf: the file's JSON is checked, then rewritten into what tinygltf 2.7 reads right.
#include "scene/gltf/fence.h"

#include "scene/file_io.h"
#include "scene/gltf/lobe_slots.h"

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <span>

namespace cmpg {
namespace {

constexpr std::uint64_t kMaxElements = std::uint64_t(1) << 30; // of an accessor
constexpr std::uint64_t kMaxPathDepth = 4096;
constexpr std::uint64_t kMaxTexcoord = 65535;
constexpr const char* kLights = "KHR_lights_punctual";

void checkBufferView(const JsonView& view, const JsonView& root) {
    const auto buffer = view["buffer"].required().index(root["buffers"].size(), "buffer");
    const std::uint64_t size = root["buffers"].at(*buffer)["byteLength"].integer(0, kMaxFileBytes);
    const std::uint64_t end = view["byteOffset"].integer(0, kMaxFileBytes) + view["byteLength"].required().integer(1, kMaxFileBytes);
    if (end > size) view.fail("reaches to byte " + std::to_string(end) + " of a buffer of " + std::to_string(size));
    const JsonView stride = view["byteStride"];
    if (stride.integer(0, 252) % 4 != 0) stride.fail("is not a multiple of 4");
}

void checkAccessor(const JsonView& accessor, const JsonView& root) {
    const std::uint32_t views = root["bufferViews"].size();
    accessor["bufferView"].index(views, "buffer view");
    accessor["byteOffset"].integer(0, kMaxFileBytes);
    accessor["componentType"].required().oneOf({5120, 5121, 5122, 5123, 5125, 5126});
    accessor["type"].required().oneOf({"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"});
    accessor["count"].required().integer(0, kMaxElements);
    accessor["normalized"].boolean(false);
    const JsonView sparse = accessor["sparse"];
    if (!sparse.exists()) return;
    sparse["count"].required().integer(0, kMaxElements);
    sparse["indices"].required()["componentType"].required().oneOf({5121, 5123, 5125});
    for (const char* part : {"indices", "values"}) {
        sparse[part]["bufferView"].required().index(views, "buffer view");
        sparse[part]["byteOffset"].integer(0, std::numeric_limits<std::int32_t>::max()); // which tinygltf keeps in an int
    }
}

void checkPrimitive(const JsonView& primitive, const JsonView& root) {
    const std::uint32_t accessors = root["accessors"].size();
    const JsonView attributes = primitive["attributes"].required();
    for (const std::string& name : attributes.keys()) attributes[name].index(accessors, "accessor");
    primitive["indices"].index(accessors, "accessor");
    primitive["material"].index(root["materials"].size(), "material");
    primitive["mode"].integer(0, 6);
}

void checkTexture(const JsonView& info, const JsonView& root) {
    if (!info.exists()) return;
    info["index"].required().index(root["textures"].size(), "texture");
    info["texCoord"].integer(0, kMaxTexcoord);
    info["scale"].number(-kLongestNormal, kLongestNormal); // of normal textures
    const JsonView transform = info["extensions"]["KHR_texture_transform"];
    transform["offset"].numbers(2);
    transform["scale"].numbers(2);
    transform["rotation"].number();
    transform["texCoord"].integer(0, kMaxTexcoord);
}

void checkMaterial(const JsonView& material, const JsonView& root) {
    material["name"].string("");
    material["alphaMode"].oneOf({"OPAQUE", "MASK", "BLEND"});
    material["alphaCutoff"].number(0);
    material["emissiveFactor"].numbers(3);
    for (const char* key : {"normalTexture", "occlusionTexture", "emissiveTexture"}) checkTexture(material[key], root);
    const JsonView pbr = material["pbrMetallicRoughness"], extensions = material["extensions"];
    pbr["baseColorFactor"].numbers(4);
    pbr["roughnessFactor"].number(0, 1);
    pbr["metallicFactor"].number(0, 1);
    for (const char* key : {"baseColorTexture", "metallicRoughnessTexture"}) checkTexture(pbr[key], root);
    const JsonView specular = extensions["KHR_materials_specular"];
    extensions["KHR_materials_transmission"]["transmissionFactor"].number(0, 1);
    checkTexture(extensions["KHR_materials_transmission"]["transmissionTexture"], root);
    const JsonView volume = extensions["KHR_materials_volume"];
    volume["thicknessFactor"].number(0);
    volume["attenuationDistance"].number(0);
    volume["attenuationColor"].numbers(3);
    checkTexture(volume["thicknessTexture"], root);
    specular["specularFactor"].number(0, 1);
    specular["specularColorFactor"].numbers(3);
    for (const char* key : {"specularTexture", "specularColorTexture"}) checkTexture(specular[key], root);
    for (const GltfLobeSlot& slot : kGltfLobeSlots) {
        const JsonView factor = extensions[slot.extension][slot.factor];
        if (slot.colour)
            factor.numbers(3);
        else
            factor.number(0, 1);
        checkTexture(extensions[slot.extension][slot.texture], root);
    }
    checkTexture(extensions["KHR_materials_clearcoat"]["clearcoatNormalTexture"], root);
    extensions["KHR_materials_anisotropy"]["anisotropyRotation"].number();
    extensions["KHR_materials_ior"]["ior"].number(0);
    extensions["KHR_materials_emissive_strength"]["emissiveStrength"].number(0);
}

void checkCamera(const JsonView& camera) {
    camera["name"].string("");
    camera["type"].required().oneOf({"perspective", "orthographic"});
    const JsonView lens = camera[camera["type"].string()];
    if (camera["type"].string() == "perspective") {
        lens["yfov"].required().number(1e-4f, glm::pi<float>() - 1e-4f);
        lens["aspectRatio"].number(1e-4f, 1e4f);
    } else {
        lens["xmag"].required().number();
        lens["ymag"].required().number();
    }
}

void checkLight(const JsonView& light) {
    light["type"].required().oneOf({"point", "spot", "directional"});
    light["color"].numbers(3);
    light["intensity"].number(0);
    light["range"].number(0);
    for (const char* key : {"innerConeAngle", "outerConeAngle"}) light["spot"][key].number(0, glm::half_pi<float>());
}

void checkNode(const JsonView& node, const JsonView& root) {
    node["name"].string("");
    node["mesh"].index(root["meshes"].size(), "mesh");
    node["camera"].index(root["cameras"].size(), "camera");
    node["skin"].integer(0, std::numeric_limits<std::int32_t>::max());
    node["extensions"][kLights]["light"].index(root["extensions"][kLights]["lights"].size(), "light");
    const std::uint32_t count = root["nodes"].size();
    node["children"].each([&](const JsonView& child) { child.index(count, "node"); });
    node["matrix"].numbers(16);
    node["translation"].numbers(3);
    node["rotation"].numbers(4);
    node["scale"].numbers(3);
}

void checkScene(const JsonView& scene, const JsonView& root) {
    const std::uint32_t count = root["nodes"].size();
    scene["nodes"].each([&](const JsonView& node) { node.index(count, "node"); });
    const JsonView extras = scene["extras"];
    if (!extras.isObject()) return; // it may be anything, and is not meant for us
    extras["maxDepth"].integer(1, kMaxPathDepth);
    const JsonView environment = extras["environment"];
    if (!environment.exists()) return;
    environment["uri"].required().string();
    environment["intensity"].number(0);
    environment["rotation"].number();
}

// tinygltf takes 3.0 for no integer, and keeps integers in extensions and extras in an int.
void normaliseNumbers(Json& value, bool generic) {
    if (value.is_number_float()) {
        constexpr double kExact = 9007199254740992; // 2^53
        const double v = value.get<double>();
        if (v == std::floor(v) && std::abs(v) <= kExact) value = std::int64_t(v);
    }
    if (generic && value.is_number() && std::abs(value.get<double>()) > double(std::numeric_limits<std::int32_t>::max()))
        value = value.get<double>();
    if (value.is_array())
        for (Json& entry : value) normaliseNumbers(entry, generic);
    if (value.is_object())
        for (auto& [key, member] : value.items()) normaliseNumbers(member, generic || key == "extensions" || key == "extras");
}

// A list that need not be there.
std::span<Json> listIn(Json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_array() ? std::span<Json>(found->get_ref<Json::array_t&>()) : std::span<Json>();
}

} // namespace

void checkGltf(const JsonView& root) {
    const auto each = [&](const char* list, void (*check)(const JsonView&, const JsonView&)) {
        root[list].each([&](const JsonView& entry) { check(entry, root); });
    };
    each("bufferViews", checkBufferView);
    each("accessors", checkAccessor);
    each("images", [](const JsonView& image, const JsonView& all) {
        image["uri"].string("");
        image["bufferView"].index(all["bufferViews"].size(), "buffer view");
        if (!image["uri"].exists() && !image["bufferView"].exists()) image.fail("has neither uri nor bufferView");
        if (image["extras"].isObject()) image["extras"]["colorSpace"].string("");
    });
    each("samplers", [](const JsonView& sampler, const JsonView&) {
        for (const char* key : {"wrapS", "wrapT"}) sampler[key].oneOf({10497, 33071, 33648});
        sampler["magFilter"].integer(0, 65535);
    });
    each("textures", [](const JsonView& texture, const JsonView& all) {
        texture["source"].index(all["images"].size(), "image");
        texture["sampler"].index(all["samplers"].size(), "sampler");
    });
    each("materials", checkMaterial);
    root["meshes"].each([&](const JsonView& mesh) {
        mesh["primitives"].each([&](const JsonView& primitive) { checkPrimitive(primitive, root); });
    });
    root["cameras"].each(checkCamera);
    root["extensions"][kLights]["lights"].each(checkLight);
    each("nodes", checkNode);
    each("scenes", checkScene);
    root["scene"].index(root["scenes"].size(), "scene");
    root["extensionsUsed"].each([](const JsonView& name) { name.string(); });
    root["animations"].size();
}

Json rewrittenForTinyGltf(Json root) {
    normaliseNumbers(root, false);
    // tinygltf takes + for a space in file names, and not every data: URI for one.
    std::size_t i = 0;
    for (Json& buffer : listIn(root, "buffers")) buffer["uri"] = kBufferToken + std::to_string(i++);
    for (Json& image : listIn(root, "images")) {
        if (!image.contains("uri")) continue;
        image["uri"] = "image";
        image.erase("bufferView"); // it refuses images with both
    }
    // It insists on clipping planes and on the cone of a spot light.
    for (Json& camera : listIn(root, "cameras")) {
        Json& lens = camera[camera["type"].get<std::string>()];
        lens["znear"] = lens["zfar"] = 0;
    }
    if (root.contains("extensions") && root["extensions"].contains(kLights))
        for (Json& light : listIn(root["extensions"][kLights], "lights")) light.emplace("spot", Json::object());
    // Damage in what is not rendered must not cost the scene.
    root.erase("skins");
    if (!listIn(root, "animations").empty()) root["animations"] = Json::array({Json::object()});
    return root;
}

} // namespace cmpg

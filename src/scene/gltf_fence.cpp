// What stands between a glTF file and tinygltf: the file's JSON is checked, then rewritten into what tinygltf 2.7 reads right.
#include "scene/gltf_fence.h"

#include "scene/file_io.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <utility>

namespace cmpg {
namespace {

constexpr std::uint64_t kMaxElements = std::uint64_t(1) << 30; // of an accessor
constexpr std::uint64_t kMaxPathDepth = 4096;
constexpr float kAny = std::numeric_limits<float>::max();

// A rule for one value; an absent value obeys all of them but required().
using Check = std::function<void(const JsonView& value, const JsonView& root)>;

Check required(Check check) {
    return [=](const JsonView& v, const JsonView& root) {
        if (!v.exists()) v.fail("is missing");
        check(v, root);
    };
}
Check text() {
    return [](const JsonView& v, const JsonView&) { v.string(""); };
}
Check flag() {
    return [](const JsonView& v, const JsonView&) { v.boolean(false); };
}
Check number(float lowest = -kAny, float highest = kAny) {
    return [=](const JsonView& v, const JsonView&) {
        if (v.exists()) v.real(lowest, highest);
    };
}
Check integer(std::uint64_t lowest, std::uint64_t highest) {
    return [=](const JsonView& v, const JsonView&) { v.integer(lowest, lowest, highest); };
}
Check numbers(std::uint32_t count) {
    return [=](const JsonView& v, const JsonView&) {
        if (!v.exists()) return;
        v.requireSize(count);
        for (std::uint32_t i = 0; i < count; ++i) v.at(i).real(-kAny, kAny);
    };
}
// One of these strings or integers.
Check oneOf(Json allowed) {
    return [=](const JsonView& v, const JsonView&) { v.requireOneOf(allowed); };
}
// An index into an array at the top level of the file, whose entries are called `noun` in messages.
Check index(const char* array, const char* noun) {
    return [=](const JsonView& v, const JsonView& root) {
        if (v.exists()) v.index(root[array].size(), noun);
    };
}
Check listOf(Check check) {
    return [=](const JsonView& v, const JsonView& root) {
        for (std::uint32_t i = 0; i < v.size(); ++i) check(v.at(i), root);
    };
}
Check membersAre(Check check) {
    return [=](const JsonView& v, const JsonView& root) {
        for (const std::string& key : v.keys()) check(v[key], root);
    };
}
// Members that are not named may be anything.
Check object(std::vector<std::pair<const char*, Check>> members) {
    return [=](const JsonView& v, const JsonView& root) {
        if (!v.exists()) return;
        v.requireObject();
        for (const auto& [key, check] : members) check(v[key], root);
    };
}
Check both(Check first, Check second) {
    return [=](const JsonView& v, const JsonView& root) { first(v, root), second(v, root); };
}
// `extras` may be anything; what is not an object is not meant for us.
Check extras(std::vector<std::pair<const char*, Check>> members) {
    return [check = object(std::move(members))](const JsonView& v, const JsonView& root) {
        if (v.isObject()) check(v, root);
    };
}

void checkBounds(const JsonView& view, const JsonView& root) {
    const std::uint64_t size = root["buffers"].at(*view["buffer"].index(~0u, "buffer"))["byteLength"].integer(0, 0, kMaxFileBytes);
    const std::uint64_t end = view["byteOffset"].integer(0, 0, kMaxFileBytes) + view["byteLength"].integer(0, 0, kMaxFileBytes);
    if (end > size) view.fail("reaches to byte " + std::to_string(end) + " of a buffer of " + std::to_string(size));
    const JsonView stride = view["byteStride"];
    if (stride.integer(0, 0, 252) % 4 != 0) stride.fail("is not a multiple of 4");
}

void checkImage(const JsonView& image, const JsonView&) {
    if (!image["uri"].exists() && !image["bufferView"].exists()) image.fail("has neither uri nor bufferView");
}

void checkCamera(const JsonView& camera, const JsonView& root) {
    camera["type"].requireOneOf({"perspective", "orthographic"});
    const JsonView lens = camera[camera["type"].string()];
    if (camera["type"].string() == "perspective") {
        required(number(1e-4f, glm::pi<float>() - 1e-4f))(lens["yfov"], root);
        number(1e-4f, 1e4f)(lens["aspectRatio"], root);
    } else {
        required(number())(lens["xmag"], root);
        required(number())(lens["ymag"], root);
    }
}

Check light() {
    return object({{"type", required(oneOf({"point", "spot", "directional"}))},
                   {"color", numbers(3)},
                   {"intensity", number(0)},
                   {"range", number(0)},
                   {"spot", object({{"innerConeAngle", number(0, glm::half_pi<float>())},
                                    {"outerConeAngle", number(0, glm::half_pi<float>())}})}});
}

Check lightIndex() {
    return [](const JsonView& v, const JsonView& root) {
        if (v.exists()) v.index(root["extensions"]["KHR_lights_punctual"]["lights"].size(), "light");
    };
}

Check textureInfo() {
    const Check set = integer(0, 65535);
    const Check transform = object({{"offset", numbers(2)}, {"scale", numbers(2)}, {"rotation", number()}, {"texCoord", set}});
    return object({{"index", required(index("textures", "texture"))},
                   {"texCoord", set},
                   {"scale", number(-1e6f, 1e6f)}, // of normal textures
                   {"extensions", object({{"KHR_texture_transform", transform}})}});
}

Check material() {
    const Check texture = textureInfo();
    const Check specular = object({{"specularFactor", number(0, 1)},
                                   {"specularTexture", texture},
                                   {"specularColorFactor", numbers(3)},
                                   {"specularColorTexture", texture}});
    return object({{"name", text()},
                   {"pbrMetallicRoughness", object({{"baseColorFactor", numbers(4)},
                                                    {"baseColorTexture", texture},
                                                    {"roughnessFactor", number(0, 1)},
                                                    {"metallicFactor", number(0, 1)},
                                                    {"metallicRoughnessTexture", texture}})},
                   {"normalTexture", texture},
                   {"occlusionTexture", texture},
                   {"emissiveTexture", texture},
                   {"emissiveFactor", numbers(3)},
                   {"alphaMode", oneOf({"OPAQUE", "MASK", "BLEND"})},
                   {"alphaCutoff", number(0)},
                   {"extensions", object({{"KHR_materials_specular", specular},
                                          {"KHR_materials_ior", object({{"ior", number(0)}})},
                                          {"KHR_materials_emissive_strength", object({{"emissiveStrength", number(0)}})}})}});
}

Check accessor() {
    const Check view = index("bufferViews", "buffer view"), count = required(integer(0, kMaxElements));
    const Check offset = integer(0, std::numeric_limits<std::int32_t>::max()); // which tinygltf keeps in an int
    const Check places = object(
        {{"bufferView", required(view)}, {"byteOffset", offset}, {"componentType", required(oneOf({5121, 5123, 5125}))}});
    return object({{"bufferView", view},
                   {"byteOffset", integer(0, kMaxFileBytes)},
                   {"componentType", required(oneOf({5120, 5121, 5122, 5123, 5125, 5126}))},
                   {"count", count},
                   {"type", required(oneOf({"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"}))},
                   {"normalized", flag()},
                   {"sparse", object({{"count", count},
                                      {"indices", required(places)},
                                      {"values", required(object({{"bufferView", required(view)}, {"byteOffset", offset}}))}})}});
}

Check primitive() {
    const Check values = index("accessors", "accessor");
    return object({{"attributes", required(membersAre(values))},
                   {"indices", values},
                   {"material", index("materials", "material")},
                   {"mode", integer(0, 6)},
                   {"targets", listOf(object({}))}});
}

Check node() {
    return object({{"name", text()},
                   {"mesh", index("meshes", "mesh")},
                   {"camera", index("cameras", "camera")},
                   {"skin", index("skins", "skin")},
                   {"children", listOf(index("nodes", "node"))},
                   {"matrix", numbers(16)},
                   {"translation", numbers(3)},
                   {"rotation", numbers(4)},
                   {"scale", numbers(3)},
                   {"extensions", object({{"KHR_lights_punctual", object({{"light", lightIndex()}})}})}});
}

Check scene() {
    const Check environment = object({{"uri", required(text())}, {"intensity", number(0)}, {"rotation", number()}});
    return object({{"nodes", listOf(index("nodes", "node"))},
                   {"extras", extras({{"maxDepth", integer(1, kMaxPathDepth)}, {"environment", environment}})}});
}

Check document() {
    const Check bufferView = object({{"buffer", required(index("buffers", "buffer"))},
                                     {"byteOffset", integer(0, kMaxFileBytes)},
                                     {"byteLength", required(integer(1, kMaxFileBytes))}});
    const Check image = object({{"uri", text()},
                                {"bufferView", index("bufferViews", "buffer view")},
                                {"extras", extras({{"colorSpace", text()}})}});
    const Check wrap = oneOf({10497, 33071, 33648});
    return object(
        {{"extensionsUsed", listOf(text())},
         {"extensionsRequired", listOf(text())},
         {"buffers", listOf(object({{"byteLength", required(integer(1, kMaxFileBytes))}, {"uri", text()}}))},
         {"bufferViews", listOf(both(bufferView, checkBounds))},
         {"accessors", listOf(accessor())},
         {"images", listOf(both(image, checkImage))},
         {"samplers", listOf(object({{"wrapS", wrap}, {"wrapT", wrap}, {"magFilter", integer(0, 65535)}}))},
         {"textures", listOf(object({{"source", index("images", "image")},
                                     {"sampler", index("samplers", "sampler")},
                                     {"extensions", object({})}}))},
         {"materials", listOf(material())},
         {"meshes", listOf(object({{"primitives", listOf(primitive())}}))},
         {"cameras", listOf(both(object({{"name", text()}, {"type", required(text())}}), checkCamera))},
         {"skins", listOf(object({}))},
         {"animations", listOf(object({}))},
         {"nodes", listOf(node())},
         {"scenes", listOf(scene())},
         {"scene", index("scenes", "scene")},
         {"extensions", object({{"KHR_lights_punctual", object({{"lights", listOf(light())}})}})}});
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

Json& listIn(Json& object, const char* key) {
    static Json none;
    none = Json::array();
    return object.contains(key) ? object[key] : none;
}

} // namespace

void checkGltf(const JsonView& root) {
    static const Check kRules = document();
    kRules(root, root);
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
        lens.emplace("znear", 0);
        lens.emplace("zfar", 0);
    }
    if (root.contains("extensions") && root["extensions"].contains("KHR_lights_punctual"))
        for (Json& light : listIn(root["extensions"]["KHR_lights_punctual"], "lights")) light.emplace("spot", Json::object());
    // Damage in what is not rendered must not cost the scene.
    root.erase("skins");
    for (Json& animation : listIn(root, "animations")) animation = Json::object();
    return root;
}

} // namespace cmpg

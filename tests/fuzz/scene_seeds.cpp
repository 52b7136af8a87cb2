// Seeds of glTF scenes: together they have every feature that the reader knows.
#include "scene/image_decode.h"
#include "seeds.h"
#include "support/scene_mutation.h"

namespace cmpg::fuzz {

using Json = nlohmann::json;

namespace {

std::string dataUri(const std::string& bytes) { return "data:application/octet-stream;base64," + test::toBase64(bytes); }

// A glTF whose accessors and images have a buffer each, embedded.
struct SceneSeed {
    Json json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", Json::array()}}}}};

    std::size_t view(const std::string& bytes) {
        json["buffers"].push_back({{"byteLength", bytes.size()}, {"uri", dataUri(bytes)}});
        json["bufferViews"].push_back({{"buffer", json["buffers"].size() - 1}, {"byteLength", bytes.size()}});
        return json["bufferViews"].size() - 1;
    }
    template <class T> std::size_t accessor(const std::vector<T>& values, int componentType, const char* type, std::size_t components, bool normalized = false) {
        json["accessors"].push_back(
            {{"bufferView", view(bytesOf(values))}, {"componentType", componentType}, {"count", values.size() / components}, {"type", type}, {"normalized", normalized}});
        return json["accessors"].size() - 1;
    }
    std::size_t vec3(const std::vector<float>& v) { return accessor(v, 5126, "VEC3", 3); }
    std::size_t vec2(const std::vector<float>& v) { return accessor(v, 5126, "VEC2", 2); }
    std::size_t indices(const std::vector<std::uint16_t>& v) { return accessor(v, 5123, "SCALAR", 1); }
    std::size_t texture(const std::string& image) {
        json["images"].push_back({{"uri", dataUri(image)}});
        json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
        json["textures"].push_back({{"source", json["images"].size() - 1}, {"sampler", 0}});
        return json["textures"].size() - 1;
    }
    void node(Json node) {
        json["nodes"].push_back(std::move(node));
        json["scenes"][0]["nodes"].push_back(json["nodes"].size() - 1);
    }
    // A quad in the plane z, facing +z, of a material; further attributes are added to the primitive returned.
    Json& quad(float z, int material) {
        Json primitive = {{"attributes", {{"POSITION", vec3({-1, -1, z, 1, -1, z, 1, 1, z, -1, 1, z})}, {"TEXCOORD_0", vec2({0, 1, 1, 1, 1, 0, 0, 0})}}},
                          {"indices", indices({0, 1, 2, 0, 2, 3})}};
        if (material >= 0)
            primitive["material"] = material;
        json["meshes"].push_back({{"primitives", {primitive}}});
        node({{"mesh", json["meshes"].size() - 1}});
        return json["meshes"].back()["primitives"][0];
    }
    void camera() {
        json["cameras"].push_back({{"type", "perspective"}, {"perspective", {{"yfov", 0.9}, {"aspectRatio", 1.5}, {"znear", 0.1}}}});
        node({{"camera", json["cameras"].size() - 1}, {"name", "eye"}, {"translation", {0, 0, 3}}});
    }
    std::string text() const { return json.dump(); }
};

// Every slot textured, masks, normal maps with tangents, second coordinates, vertex colours, transforms.
SceneSeed texturedScene() {
    SceneSeed s;
    const std::size_t rgba = s.texture(pngOf(4, 2, 4)), rgb = s.texture(pngOf(2, 2, 3)), grey = s.texture(textOf(encodeExr(Image(2, 1, 1, 0.5f))));
    const Json transform = {{"KHR_texture_transform", {{"offset", {0.1, 0.2}}, {"scale", {2, 3}}, {"rotation", 0.5}, {"texCoord", 1}}}};
    s.json["materials"] = {
        {{"name", "all"},
         {"alphaMode", "MASK"},
         {"alphaCutoff", 0.4},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.8, 0.7, 0.6, 0.9}},
           {"roughnessFactor", 0.5},
           {"metallicFactor", 0.3},
           {"baseColorTexture", {{"index", rgba}, {"extensions", transform}}},
           {"metallicRoughnessTexture", {{"index", rgb}, {"texCoord", 1}}}}},
         {"normalTexture", {{"index", rgb}, {"scale", 0.7}}},
         {"occlusionTexture", {{"index", rgb}}},
         {"emissiveTexture", {{"index", grey}}},
         {"emissiveFactor", {1, 0.5, 0.2}},
         {"extensions",
          {{"KHR_materials_specular", {{"specularFactor", 0.7}, {"specularTexture", {{"index", rgba}}}, {"specularColorFactor", {1, 0.9, 0.8}}}},
           {"KHR_materials_ior", {{"ior", 1.4}}},
           {"KHR_materials_emissive_strength", {{"emissiveStrength", 3}}}}}},
        {{"name", "plain"}, {"pbrMetallicRoughness", {{"metallicFactor", 0}}}}};
    Json& attributes = s.quad(0, 0)["attributes"];
    attributes["NORMAL"] = s.vec3({0, 0, 1, 0, 0, 1, 0, 0.1f, 1, 0, 0, 1});
    attributes["TANGENT"] = s.accessor<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1, 1, 0, 0, 1}, 5126, "VEC4", 4);
    attributes["TEXCOORD_1"] = s.accessor<std::uint16_t>({0, 0, 65535, 0, 65535, 65535, 0, 65535}, 5123, "VEC2", 2, true);
    attributes["COLOR_0"] = s.accessor<std::uint8_t>({255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 9, 9, 9, 255}, 5121, "VEC4", 4, true);
    s.quad(-1, 1);
    s.json["extensionsUsed"] = {"KHR_materials_specular", "KHR_materials_ior", "KHR_materials_emissive_strength", "KHR_texture_transform"};
    s.json["images"][0]["extras"] = {{"colorSpace", "linear"}};
    s.camera();
    return s;
}

// Clear coats, anisotropy, sheen, glass with an absorbing volume, a pane, partial coverage.
SceneSeed layeredScene() {
    SceneSeed s;
    const std::size_t rgba = s.texture(pngOf(4, 2, 4)), rgb = s.texture(pngOf(2, 2, 3));
    const Json smooth = {{"roughnessFactor", 0.2}, {"metallicFactor", 0}};
    s.json["materials"] = {
        {{"name", "varnish"},
         {"pbrMetallicRoughness", {{"metallicFactor", 0.5}}},
         {"extensions",
          {{"KHR_materials_clearcoat",
            {{"clearcoatFactor", 0.7},
             {"clearcoatTexture", {{"index", rgb}}},
             {"clearcoatRoughnessFactor", 0.4},
             {"clearcoatRoughnessTexture", {{"index", rgb}}},
             {"clearcoatNormalTexture", {{"index", rgb}, {"scale", 0.5}}}}},
           {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.6}, {"anisotropyRotation", 0.3}, {"anisotropyTexture", {{"index", rgb}}}}},
           {"KHR_materials_sheen",
            {{"sheenColorFactor", {0.9, 0.5, 0.1}},
             {"sheenColorTexture", {{"index", rgba}}},
             {"sheenRoughnessFactor", 0.4},
             {"sheenRoughnessTexture", {{"index", rgba}}}}}}}},
        {{"name", "ink"},
         {"pbrMetallicRoughness", smooth},
         {"extensions",
          {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
           {"KHR_materials_volume", {{"thicknessFactor", 1}, {"attenuationDistance", 0.5}, {"attenuationColor", {0.9, 0.5, 0.1}}}},
           {"KHR_materials_ior", {{"ior", 1.33}}}}}},
        {{"name", "pane"}, {"pbrMetallicRoughness", smooth}, {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.9}}}}}},
        {{"name", "leaf"},
         {"alphaMode", "BLEND"},
         {"emissiveFactor", {1, 1, 1}},
         {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.8}}, {"baseColorTexture", {{"index", rgba}}}}}}};
    for (int material = 0; material < 4; ++material)
        s.quad(float(-material), material);
    s.json["extensionsUsed"] = {"KHR_materials_clearcoat", "KHR_materials_anisotropy", "KHR_materials_sheen", "KHR_materials_transmission", "KHR_materials_volume", "KHR_materials_ior"};
    s.camera();
    return s;
}

// Lights and cameras of all kinds, an environment, a hierarchy of nodes.
SceneSeed litScene() {
    SceneSeed s;
    s.json["materials"] = {{{"name", "floor"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.5, 0.5, 1}}, {"metallicFactor", 0.1}}}},
                           {{"name", "lamp"}, {"emissiveFactor", {1, 1, 1}}, {"alphaMode", "BLEND"}}};
    s.quad(0, 0);
    s.quad(4, 1);
    s.quad(-2, -1);
    s.json["nodes"][1]["rotation"] = {1, 0, 0, 0};
    s.json["nodes"][2]["matrix"] = {-1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, 0.5, 1};
    s.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"intensity", 20}, {"color", {1, 0.5, 0.5}}, {"range", 10}},
        {{"type", "spot"}, {"intensity", 30}, {"spot", {{"innerConeAngle", 0.2}, {"outerConeAngle", 0.6}}}},
        {{"type", "directional"}, {"intensity", 2}}};
    for (int light = 0; light < 3; ++light)
        s.json["nodes"].push_back({{"translation", {light - 1, 0.5, 2}}, {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
    s.node({{"children", {3, 4, 5}}, {"scale", {1, 1, 2}}});
    s.camera();
    s.json["cameras"].push_back({{"type", "orthographic"}, {"orthographic", {{"xmag", 2}, {"ymag", 1}, {"znear", 0}, {"zfar", 9}}}});
    s.node({{"camera", 1}, {"translation", {0, 0, 3}}});
    s.json["scenes"][0]["extras"] = {{"maxDepth", 4}, {"environment", {{"uri", "sky.exr"}, {"intensity", 2}, {"rotation", 0.3}}}};
    s.json["scenes"][0]["extras"]["environment"]["uri"] = dataUri(textOf(encodeExr(Image(4, 2, 3, 0.25f))));
    return s;
}

// Accessors of all kinds: sparse, quantised, strided, without data, strips and fans, files beside the scene.
SceneSeed packedScene() {
    SceneSeed s;
    s.json["materials"] = {{{"name", "a"}, {"emissiveFactor", {1, 1, 1}}}};
    Json& strip = s.quad(0, 0);
    strip["mode"] = 5;
    const std::size_t where = s.view(bytesOf<std::uint8_t>({2, 0})), what = s.view(bytesOf<float>({1, 2, 0.5f}));
    s.json["accessors"][strip["attributes"]["POSITION"].get<std::size_t>()]["sparse"] = {
        {"count", 1}, {"indices", {{"bufferView", where}, {"componentType", 5121}}}, {"values", {{"bufferView", what}}}};
    Json& fan = s.quad(1, 0);
    fan["mode"] = 6;
    fan["attributes"]["POSITION"] = s.accessor<std::int8_t>({-127, -127, 0, 0, 127, -127, 0, 0, 127, 127, 0, 0, -127, 127, 0, 0}, 5120, "VEC3", 4, true);
    s.json["bufferViews"].back()["byteStride"] = 4;
    s.json["accessors"].push_back({{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
    fan["attributes"]["NORMAL"] = s.json["accessors"].size() - 1;
    Json& points = s.quad(2, 0);
    points["mode"] = 0;
    s.json["buffers"].push_back({{"uri", "data.bin"}, {"byteLength", 36}});
    s.json["bufferViews"].push_back({{"buffer", s.json["buffers"].size() - 1}, {"byteLength", 36}});
    s.json["accessors"].push_back({{"bufferView", s.json["bufferViews"].size() - 1}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
    s.quad(3, 0)["attributes"] = {{"POSITION", s.json["accessors"].size() - 1}};
    s.json["meshes"].back()["primitives"][0].erase("indices");
    s.json["images"] = {{{"uri", "image.png"}}};
    s.json["textures"] = {{{"source", 0}}};
    s.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    s.json["extensionsUsed"] = s.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    s.json["skins"] = {{{"joints", {0}}}};
    s.json["animations"] = {{{"channels", Json::array()}}};
    return s;
}

std::string word(std::size_t value) { return bytesOf<std::uint32_t>({std::uint32_t(value)}); }

// A triangle and an image in the binary chunk.
std::string binaryScene() {
    std::string binary = bytesOf<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});
    const std::string png = pngOf(2, 2, 3);
    const std::size_t imageBytes = png.size();
    binary += png;
    binary.resize((binary.size() + 3) / 4 * 4);
    const Json json = {{"asset", {{"version", "2.0"}}},
                       {"scenes", {{{"nodes", {0}}}}},
                       {"nodes", {{{"mesh", 0}}}},
                       {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"material", 0}}}}}}},
                       {"materials", {{{"emissiveFactor", {1, 1, 1}}, {"emissiveTexture", {{"index", 0}}}}}},
                       {"textures", {{{"source", 0}}}},
                       {"images", {{{"bufferView", 1}, {"mimeType", "image/png"}}}},
                       {"accessors", {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}}},
                       {"bufferViews", {{{"buffer", 0}, {"byteLength", 36}}, {{"buffer", 0}, {"byteOffset", 36}, {"byteLength", imageBytes}}}},
                       {"buffers", {{{"byteLength", binary.size()}}}}};
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    return "glTF" + word(2) + word(12 + 8 + text.size() + 8 + binary.size()) + word(text.size()) + "JSON" + text + word(binary.size()) + std::string("BIN\0", 4) + binary;
}

} // namespace

void writeScenes(const Folder& out) {
    out.write("textured.gltf", texturedScene().text());
    out.write("layered.gltf", layeredScene().text());
    out.write("lit.gltf", litScene().text());
    out.write("packed.gltf", packedScene().text());
    out.write("binary.glb", binaryScene());
}

} // namespace cmpg::fuzz

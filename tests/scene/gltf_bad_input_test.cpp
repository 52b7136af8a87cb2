// Hostile and damaged scenes: always Error(Input) that names the file and the thing, never a crash.
#include "gltf_writer.h"
#include "test_images.h"

#include <cmath>
#include <functional>
#include <random>
#include <set>
#include <sys/stat.h>

namespace cmpg::test {
namespace {

struct Case {
    const char* name;
    std::function<void(GltfWriter&)> damage;
    const char* mentions; // in the message
};

Json& json(GltfWriter& w, const char* pointer) { return w.json[Json::json_pointer(pointer)]; }

// Sets one place of the JSON.
std::function<void(GltfWriter&)> set(const char* pointer, Json value) {
    return [=](GltfWriter& w) { json(w, pointer) = value; };
}

void image(GltfWriter& w, const char* uri) {
    w.json["images"] = {{{"uri", uri}}};
    w.json["textures"] = {{{"source", 0}}};
    json(w, "/materials/0/pbrMetallicRoughness/baseColorTexture") = {{"index", 0}};
}
std::function<void(GltfWriter&)> withImage(const char* uri) {
    return [=](GltfWriter& w) { image(w, uri); };
}

std::function<void(GltfWriter&)> sparse(Json value) {
    return [=](GltfWriter& w) {
        const std::size_t where = w.view(std::vector<std::uint8_t>{1, 9}), what = w.view(std::vector<float>(6, 1));
        Json s = {{"count", 2}, {"indices", {{"bufferView", where}, {"componentType", 5121}}}, {"values", {{"bufferView", what}}}};
        s.merge_patch(value);
        json(w, "/accessors/0/sparse") = s;
    };
}

constexpr const char* kPositions = "/meshes/0/primitives/0/attributes/POSITION";
const float kNan = std::nanf(""), kInfinity = HUGE_VALF;

std::vector<Case> cases() {
    return {
        // The container and the structure.
        {"no asset", [](GltfWriter& w) { w.json.erase("asset"); }, "asset.version is missing"},
        {"glTF 1", set("/asset/version", "1.0"), "asset.version"},
        {"required extension", set("/extensionsRequired", {"KHR_draco_mesh_compression"}), "KHR_draco_mesh_compression"},
        {"nodes is a number", set("/nodes", 3), "nodes"},
        {"animations is a number", set("/animations", -1), "animations"},
        {"a node is a string", set("/nodes/0", "x"), "nodes[0]"},
        {"scene out of range", set("/scene", 7), "scene names scene 7"},
        {"negative scene", set("/scene", -1), "scene"},
        {"node out of range", set("/scenes/0/nodes", {5}), "scenes[0].nodes[0]"},
        {"child out of range", set("/nodes/0/children", {4000000000u}), "nodes[0].children[0]"},
        {"node is its own child", set("/nodes/0/children", {0}), "nodes[0] is reached twice"},
        {"cycle of two", set("/nodes", {{{"mesh", 0}, {"children", {1}}}, {{"children", {0}}}}), "is reached twice"},
        {"two parents", set("/nodes", {{{"children", {1, 2}}}, {{"children", {3}}}, {{"children", {3}}}, {{"mesh", 0}}}), "nodes[3]"},
        {"mesh out of range", set("/nodes/0/mesh", 1), "nodes[0].mesh"},
        {"fractional index", set("/nodes/0/mesh", 0.5), "nodes[0].mesh"},
        {"index as a string", set("/nodes/0/mesh", "0"), "nodes[0].mesh"},
        {"material out of range", set("/meshes/0/primitives/0/material", 1), "material"},
        {"accessor out of range", set(kPositions, 99), "POSITION"},
        {"unknown mode", set("/meshes/0/primitives/0/mode", 7), "mode"},
        {"short matrix", set("/nodes/0/matrix", {1, 2, 3}), "nodes[0].matrix"},
        {"perspective matrix", set("/nodes/0/matrix", {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}), "nodes[0].matrix"},
        {"zero rotation", set("/nodes/0/rotation", {0, 0, 0, 0}), "nodes[0].rotation"},
        {"huge scale", set("/nodes/0/scale", {1e300, 1, 1}), "nodes[0].scale"},
        {"scales that multiply to infinity",
         set("/nodes", {{{"children", {1}}, {"scale", {1e30, 1, 1}}}, {{"mesh", 0}, {"scale", {1e30, 1, 1}}}}), "nodes[1]"},
        {"a vertex scaled to infinity",
         [](GltfWriter& w) {
             json(w, kPositions) = w.floats({0, 0, 0, 1e10f, 0, 0, 0, 1, 0}, 3);
             json(w, "/nodes/0/scale") = {1e30, 1, 1};
         },
         "POSITION"},
        {"infinite emission",
         [](GltfWriter& w) {
             json(w, "/materials/0/emissiveFactor") = {1e30, 0, 0};
             json(w, "/materials/0/extensions") = {{"KHR_materials_emissive_strength", {{"emissiveStrength", 1e30}}}};
         },
         "emissiveFactor"},
        // Buffers and accessors.
        {"absurd count", set("/accessors/0/count", 4000000000u), "accessors[0].count"},
        {"count beyond the data", set("/accessors/0/count", 4), "accessors[0]"},
        {"absurd count without data",
         [](GltfWriter& w) { json(w, "/accessors/0") = {{"componentType", 5126}, {"type", "VEC3"}, {"count", 300000000}}; },
         "accessors[0].count"},
        {"negative count", set("/accessors/0/count", -3), "accessors[0].count"},
        {"offset that wraps around", set("/accessors/0/byteOffset", 18446744073709551615u), "accessors[0].byteOffset"},
        {"offset beyond the view", set("/accessors/0/byteOffset", 4), "accessors[0]"},
        {"view beyond the buffer", set("/bufferViews/0/byteLength", 100000), "bufferViews[0]"},
        {"view offset beyond the buffer", set("/bufferViews/0/byteOffset", 4000000000u), "bufferViews[0]"},
        {"view of no buffer", set("/bufferViews/0/buffer", 1), "bufferViews[0].buffer"},
        {"stride below the element", set("/bufferViews/0/byteStride", 4), "byteStride"},
        {"component type", set("/accessors/0/componentType", 5127), "componentType"},
        {"accessor type", set("/accessors/0/type", "MAT4"), "accessors[0].type"},
        {"two components for positions", set("/accessors/0/type", "VEC2"), "accessors[0].type"},
        {"texture coordinates too few", set("/accessors/1/count", 2), "TEXCOORD_0"},
        {"NaN vertex", [](GltfWriter& w) { json(w, kPositions) = w.floats({0, 0, 0, 1, kNan, 0, 0, 1, 0}, 3); }, "not finite at element 1"},
        {"infinite vertex", [](GltfWriter& w) { json(w, kPositions) = w.floats({0, 0, 0, 1, 0, 0, 0, kInfinity, 0}, 3); }, "POSITION"},
        {"index out of range", [](GltfWriter& w) { json(w, "/meshes/0/primitives/0/indices") = w.indices({0, 1, 3}); }, "names vertex 3"},
        {"float indices", [](GltfWriter& w) { json(w, "/meshes/0/primitives/0/indices") = w.floats({0, 1, 2}, 1); }, "componentType"},
        {"sparse index out of range", sparse(Json::object()), "sparse.indices names element 9"},
        {"more sparse values than elements", sparse({{"count", 4}}), "sparse.count"},
        {"sparse values beyond the view", sparse({{"values", {{"byteOffset", 20}}}}), "sparse.values"},
        {"sparse without indices", sparse({{"indices", nullptr}}), "sparse.indices"},
        // Materials, cameras, lights.
        {"colour of two numbers", set("/materials/0/pbrMetallicRoughness", {{"baseColorFactor", {1, 1}}}), "baseColorFactor"},
        {"roughness above 1", set("/materials/0/pbrMetallicRoughness", {{"roughnessFactor", 3}}), "roughnessFactor"},
        {"alpha mode", set("/materials/0/alphaMode", "GLASS"), "GLASS"},
        {"texture out of range", set("/materials/0/normalTexture", {{"index", 0}}), "normalTexture.index"},
        {"texture without index", set("/materials/0/normalTexture", Json::object()), "normalTexture.index"},
        {"wrap mode",
         [](GltfWriter& w) {
             image(w, "x.png");
             w.json["samplers"] = {{{"wrapS", 1}}};
             json(w, "/textures/0/sampler") = 0;
         },
         "samplers[0].wrapS"},
        {"camera type", [](GltfWriter& w) { w.json["cameras"] = {{{"type", "fisheye"}}}, json(w, "/nodes/0/camera") = 0; }, "fisheye"},
        {"camera without angle",
         [](GltfWriter& w) { w.json["cameras"] = {{{"type", "perspective"}}}, json(w, "/nodes/0/camera") = 0; }, "yfov"},
        {"camera of a turn",
         [](GltfWriter& w) {
             w.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 6.3}}}}};
             json(w, "/nodes/0/camera") = 0;
         },
         "yfov"},
        {"light out of range", set("/nodes/0/extensions", {{"KHR_lights_punctual", {{"light", 0}}}}), "light"},
        {"depth of 0", set("/scenes/0/extras", {{"maxDepth", 0}}), "maxDepth"},
        {"environment without uri", set("/scenes/0/extras", {{"environment", Json::object()}}), "environment.uri"},
        // Files that a scene names.
        {"missing image", withImage("nowhere.png"), "nowhere.png"},
        {"missing buffer", set("/buffers", {{{"uri", "gone.bin"}, {"byteLength", 4}}}), "gone.bin"},
        {"buffer shorter than declared", set("/buffers", {{{"uri", "data.bin"}, {"byteLength", 1000000}}}), "buffers[0]"},
        {"parent folder", withImage("../secret.png"), "leaves the scene's folder"},
        {"parent folder, encoded", withImage("%2e%2E%2Fsecret.png"), "leaves the scene's folder"},
        {"parent folder, roundabout", withImage("inside/../../secret.png"), "leaves the scene's folder"},
        {"absolute path", withImage("/etc/passwd"), "not a relative path"},
        {"absolute path, encoded", withImage("%2Fetc%2Fpasswd"), "not a relative path"},
        {"file scheme", withImage("file:///etc/passwd"), "not a relative path"},
        {"network", withImage("https://example.org/a.png"), "not a relative path"},
        {"backslashes", withImage("..\\secret.png"), "has \\ between"},
        {"link out of the folder", withImage("link/secret.png"), "leaves the scene's folder"},
        {"zero byte", withImage("a%00.png"), "zero byte"},
        {"bad escape", withImage("a%4"), "not a valid URI"},
        {"a folder", withImage("inside"), "not a regular file"},
        {"a pipe", withImage("pipe"), "not a regular file"},
        {"not an image", withImage("data.bin"), "images[0]"},
        {"data without base64", withImage("data:image/png,abc"), "data: URI"},
        {"bad base64", withImage("data:image/png;base64,!!!!"), "base64"},
        {"image of an unknown kind", withImage("data:image/gif;base64,R0lGODlhAQABAAAAACw="), "images[0]"},
        {"wide image", withImage("wide.png"), "wide.png"},
        {"environment elsewhere", set("/scenes/0/extras", {{"environment", {{"uri", "../sky.exr"}}}}), "leaves the scene's folder"},
    };
}

// The scene's folder with what the cases refer to: scene/, and a file beside it that no scene may read.
struct Fixture {
    TempFolder folder;
    fs::path scene = folder / "scene/scene.gltf";

    Fixture() {
        savePng(folder / "secret.png", 1, 1, 3, {1, 2, 3});
        fs::create_directories(folder / "scene/inside");
        fs::create_symlink("..", folder / "scene/link");
        mkfifo((folder / "scene/pipe").c_str(), 0600);
        savePng(folder / "scene/wide.png", 8193, 1, 1, std::vector<std::uint8_t>(8193));
    }
    void write(GltfWriter& w) {
        if (!w.json.contains("buffers")) w.finish(false);
        writeText(folder / "scene/data.bin", w.data);
        writeText(scene, w.json.dump());
    }
};

TEST(GltfBadInput, EveryCaseIsAnInputErrorThatNamesThePlace) {
    Fixture f;
    for (const Case& c : cases()) {
        SCOPED_TRACE(c.name);
        GltfWriter w = oneTriangle();
        c.damage(w);
        f.write(w);
        try {
            loadScene(f.scene);
            ADD_FAILURE() << "loaded";
        } catch (const Error& e) {
            const std::string message = e.what();
            EXPECT_EQ(e.kind, ErrorKind::Input);
            EXPECT_NE(message.find("scene.gltf"), std::string::npos) << message;
            EXPECT_NE(message.find(c.mentions), std::string::npos) << message;
            EXPECT_FALSE(e.cause.empty()) << message;
            EXPECT_FALSE(e.remedy.empty()) << message;
        }
    }
}

TEST(GltfBadInput, TheUndamagedSceneLoads) {
    Fixture f;
    GltfWriter w = oneTriangle();
    image(w, "inside/%61.png"); // an escape, and a file within
    savePng(f.folder / "scene/inside/a.png", 2, 2, 3, std::vector<std::uint8_t>(12, 7));
    f.write(w);
    EXPECT_EQ(loadScene(f.scene).geometry.triangles.size(), 1u);
    // A link to the scene finds the files beside the scene itself.
    fs::create_symlink(f.scene, f.folder / "elsewhere.gltf");
    EXPECT_EQ(loadScene(f.folder / "elsewhere.gltf").geometry.triangles.size(), 1u);
}

// Loads whatever the file is; anything but success and Error(Input) fails (and a crash ends the test).
std::optional<ErrorKind> outcome(const fs::path& file) {
    try {
        loadScene(file);
        return std::nullopt;
    } catch (const Error& e) {
        return e.kind;
    }
}

TEST(GltfBadInput, FilesThatAreNoScenes) {
    const TempFolder folder;
    EXPECT_EQ(outcome(folder / "none.gltf"), ErrorKind::Input);
    EXPECT_EQ(outcome(folder.path()), ErrorKind::Input);
    EXPECT_EQ(outcome("/dev/zero"), ErrorKind::Input);
    const std::string open(100000, '['), close(100000, ']');
    const std::vector<std::string> texts = {
        "",   "{",  "[]",
        "3",  "null", "\xff\xfe",
        open, "{\"asset\":{\"version\":1e999}}", "{\"asset\":{\"version\":\"2.0\"},\"extras\":" + open + close + "}",
        "glTF", std::string("glTF\2\0\0\0\xff\xff\xff\xff\0\0\0\0JSON", 20),
    };
    for (const std::string& text : texts) {
        writeText(folder / "x.gltf", text);
        EXPECT_EQ(outcome(folder / "x.gltf"), ErrorKind::Input) << text.substr(0, 40);
    }
}

TEST(GltfBadInput, ChainsOfNodesAreNoRecursion) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    Json& nodes = w.json["nodes"];
    for (int i = 0; i < 200000; ++i) nodes.push_back({{"children", {i + 2}}});
    nodes.push_back({{"mesh", 0}});
    nodes[0] = {{"children", {1}}};
    EXPECT_EQ(loadScene(w.write(folder)).geometry.triangles.size(), 1u);
}

GltfWriter richScene(const TempFolder& folder) {
    GltfWriter w = oneTriangle();
    savePng(folder / "c.png", 4, 4, 4, std::vector<std::uint8_t>(64, 99));
    const std::string png = readText(folder / "c.png");
    w.json["images"] = {{{"bufferView", w.view(std::vector<std::uint8_t>(png.begin(), png.end()))}, {"mimeType", "image/png"}}};
    w.json["samplers"] = {{{"wrapS", 33071}, {"magFilter", 9728}}};
    w.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
    json(w, "/materials/0") = {{"name", "m"},
                               {"alphaMode", "MASK"},
                               {"normalTexture", {{"index", 0}, {"scale", 0.5}}},
                               {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"baseColorFactor", {1, 1, 1, 1}}}},
                               {"extensions", {{"KHR_materials_ior", {{"ior", 1.4}}}}}};
    primitive(w)["indices"] = w.indices({0, 1, 2});
    w.json["skins"] = {{{"joints", {0}}}};
    w.json["animations"] = {{{"channels", {{{"sampler", 0}}}}}};
    w.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}}}}};
    json(w, "/nodes/0/camera") = 0;
    json(w, "/nodes/0/extensions") = {{"KHR_lights_punctual", {{"light", 0}}}};
    json(w, "/extensions") = {{"KHR_lights_punctual", {{"lights", {{{"type", "spot"}, {"intensity", 3}}}}}}};
    const std::size_t where = w.view(std::vector<std::uint8_t>{2}), what = w.view(std::vector<float>{0, 2, 0});
    json(w, "/accessors/0/sparse") = {
        {"count", 1}, {"indices", {{"bufferView", where}, {"componentType", 5121}}}, {"values", {{"bufferView", what}}}};
    return w;
}

// At 64 lengths, and at every one within the header and the heads of the chunks.
TEST(GltfBadInput, TruncationsOfABinaryScene) {
    const TempFolder folder;
    GltfWriter w = richScene(folder);
    const std::string whole = w.glb();
    writeText(folder / "s.glb", whole);
    ASSERT_EQ(outcome(folder / "s.glb"), std::nullopt);
    constexpr std::size_t kHeader = 12, kHead = 8;
    std::uint32_t json = 0;
    std::memcpy(&json, whole.data() + kHeader, sizeof json);
    const std::size_t binary = kHeader + kHead + json;
    ASSERT_EQ(whole.substr(binary + 4, 3), "BIN");
    std::set<std::size_t> lengths;
    for (std::size_t i = 0; i < 64; ++i)
        lengths.insert(whole.size() * i / 64);
    for (std::size_t i = 0; i <= kHeader + kHead + 1; ++i)
        lengths.insert(i);
    for (std::size_t i = binary - 1; i <= binary + kHead + 1; ++i)
        lengths.insert(i);
    lengths.insert(whole.size() - 1);
    for (const std::size_t size : lengths) {
        std::string cut = whole.substr(0, size);
        writeText(folder / "s.glb", cut);
        EXPECT_EQ(outcome(folder / "s.glb"), ErrorKind::Input) << size << " of " << whole.size();
        if (cut.size() < kHeader) continue;
        const auto length = std::uint32_t(cut.size()); // as if the header agreed
        std::memcpy(cut.data() + 8, &length, 4);
        writeText(folder / "s.glb", cut);
        EXPECT_EQ(outcome(folder / "s.glb"), ErrorKind::Input) << size << " of " << whole.size() << ", header adjusted";
    }
}

TEST(GltfBadInput, RandomDamageNeverCrashes) {
    const TempFolder folder;
    GltfWriter w = richScene(folder);
    const std::string whole = w.glb();
    std::mt19937 random(1);
    int loaded = 0, refused = 0;
    for (int trial = 0; trial < 3000; ++trial) {
        std::string damaged = whole;
        const int places = 1 + int(random() % 4);
        for (int i = 0; i < places; ++i) {
            // Digits and brackets reach further than noise, which mostly only breaks the JSON.
            constexpr char kLikely[] = "0123456789-[]{}\",:e.";
            char& c = damaged[random() % damaged.size()];
            c = random() % 4 ? kLikely[random() % (sizeof(kLikely) - 1)] : char(random());
        }
        writeText(folder / "s.glb", damaged);
        const std::optional<ErrorKind> code = outcome(folder / "s.glb");
        (code == std::nullopt ? loaded : refused) += 1;
        ASSERT_TRUE(code == std::nullopt || code == ErrorKind::Input) << "trial " << trial;
    }
    EXPECT_GT(loaded, 100) << "the damage should not all be trivial";
    EXPECT_GT(refused, 100);
}

// Structural damage: any value of the JSON replaced by one of another type or size.
TEST(GltfBadInput, ReplacedValuesNeverCrash) {
    const TempFolder folder;
    GltfWriter w = richScene(folder);
    w.write(folder);
    const Json original = w.json, flat = original.flatten();
    const std::vector<Json> others = {nullptr, -1, 1e30, 0.5, 4294967296u, "x", true, Json::array(), Json::object(), {1, 2}, {{"a", 1}}};
    std::set<std::string> places;
    for (const auto& [pointer, value] : flat.items())
        for (std::string p = pointer; !p.empty(); p = p.substr(0, p.rfind('/'))) places.insert(p); // and everything around it
    for (const std::string& place : places)
        for (const Json& other : others) {
            Json changed = original;
            changed[Json::json_pointer(place)] = other;
            writeText(folder / "scene.gltf", changed.dump());
            const std::optional<ErrorKind> code = outcome(folder / "scene.gltf");
            ASSERT_TRUE(code == std::nullopt || code == ErrorKind::Input) << place << " = " << other.dump();
        }
}

} // namespace
} // namespace cmpg::test

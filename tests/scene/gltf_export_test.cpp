// Export: a scene written with changed parameters loads back with the same values.
#include "base/log.h"
#include "gltf_writer.h"
#include "scene/export_folder.h"
#include "scene/file_io.h"
#include "scene/image.h"
#include "test_images.h"

#include <cmath>
#include <set>

namespace cmpg::test {
namespace {

// A scene with every slot textured in one material, constant in another, and an environment.
struct Fixture {
    TempFolder folder;
    GltfWriter w = oneTriangle();

    Fixture() {
        std::vector<std::uint8_t> codes;
        for (int i = 0; i < 4 * 4 * 4; ++i) codes.push_back(std::uint8_t(i * 37 + 11));
        savePng(folder / "tex/a b.png", 4, 4, 4, codes);
        w.json["images"] = {{{"uri", "tex/a%20b.png"}}};
        w.json["samplers"] = {{{"wrapS", 33071}}};
        w.json["textures"] = {{{"source", 0}, {"sampler", 0}}};
        const Json info = {{"index", 0}, {"extensions", {{"KHR_texture_transform", {{"offset", {0.5, 0}}}}}}};
        w.json["materials"] = {
            {{"name", "a/b"},
             {"pbrMetallicRoughness",
              {{"baseColorTexture", info}, {"baseColorFactor", {0.5, 1, 1, 0.75}}, {"metallicRoughnessTexture", info}}},
             {"normalTexture", {{"index", 0}, {"scale", 0.5}}},
             {"emissiveTexture", info},
             {"emissiveFactor", {1, 1, 1}},
             {"extensions", {{"KHR_materials_specular", {{"specularTexture", info}}}}}},
            {{"name", "plain"}, {"alphaMode", "MASK"}}};
        w.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"material", 1}});
        w.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}}); // the default material
        saveExr(folder / "sky.exr", 4, 3, "RGB", std::vector<float>(36, 0.25f));
        w.json["scenes"][0]["extras"]["environment"] = {{"uri", "sky.exr"}, {"intensity", 3}, {"rotation", 1}};
    }
};

// Changes every value of a parameter to something within its range.
void change(Parameter& p) {
    p.materialise();
    for (std::size_t i = 0; i < p.values.size(); ++i) {
        const float v = 0.5f + 0.5f * std::sin(float(i) * 1.7f + float(p.name.size()));
        p.values[i] = p.kind == SlotKind::Emission || p.kind == SlotKind::Radiance ? 20 * v : v;
    }
    if (p.kind == SlotKind::Normal)
        for (std::size_t i = 0; i < p.values.size(); i += 3) {
            const glm::vec3 n = glm::normalize(glm::vec3(p.values[i] - 0.5f, p.values[i + 1] - 0.5f, 1));
            for (int c = 0; c < 3; ++c) p.values[i + std::size_t(c)] = n[c];
        }
}

// Half a code of 8 bits in the encoding of the slot; constants and the environment are exact up to float rounding.
float tolerance(const Parameter& p, float value, float largest) {
    if (!p.textured || p.kind == SlotKind::Radiance) return 1e-6f * largest;
    if (p.kind == SlotKind::Normal) return 1.01f / 255;
    if (p.channels == 1) return 0.505f / 255;
    const float code = srgbEncode(value / largest), half = 0.505f / 255;
    return largest * (srgbDecode(std::min(code + half, 1.0f + half)) - srgbDecode(std::max(code - half, 0.0f)));
}

void expectSame(const Scene& a, const Scene& b) {
    ASSERT_EQ(a.parameters.size(), b.parameters.size());
    for (const Parameter& pa : a.parameters) {
        const Parameter& pb = find(b, pa.name);
        SCOPED_TRACE(pa.name);
        EXPECT_EQ(pa.textured, pb.textured);
        EXPECT_EQ(pa.wrapU, pb.wrapU);
        EXPECT_EQ(pa.uvTransform, pb.uvTransform);
        const std::vector<float> va = valuesOf(a, pa.name), vb = valuesOf(b, pa.name);
        ASSERT_EQ(va.size(), vb.size());
        const bool bright = pa.kind == SlotKind::Emission || pa.kind == SlotKind::Radiance;
        const float largest = bright ? std::max(*std::max_element(va.begin(), va.end()), 1e-9f) : 1.0f;
        for (std::size_t i = 0; i < va.size(); ++i) ASSERT_NEAR(va[i], vb[i], tolerance(pa, va[i], largest)) << i;
    }
}

TEST(GltfExport, EveryChangedSlotLoadsBack) {
    Fixture f;
    Scene s = loadScene(f.w.write(f.folder));
    std::vector<std::uint32_t> changed;
    for (std::uint32_t i = 0; i < s.parameters.size(); ++i) {
        if (s.parameters[i].kind == SlotKind::Normal && !s.parameters[i].textured) continue;
        change(s.parameters[i]);
        changed.push_back(i);
    }
    const TempFolder out;
    exportScene(s, changed, out.path());
    const Scene back = loadScene(out / "scene.gltf");
    expectSame(s, back);
    EXPECT_EQ(back.environment->rotation, 1);
    EXPECT_EQ(back.materials[0].name, "a/b");
    EXPECT_EQ(back.geometry.positions, s.geometry.positions);
    EXPECT_EQ(back.geometry.triangles[2].material, 2u);

    // Exact values, one file each; the names are safe.
    EXPECT_EQ(readImage(out / "parameters/a%2Fb.baseColor.exr").image.values, valuesOf(s, "a/b.baseColor"));
    const Json json = Json::parse(readText(out / "scene.gltf"));
    EXPECT_EQ(json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"], Json({1, 1, 1, 0.75}));
    // What other programs insist on: emissiveFactor within [0,1], used extensions listed, alpha kept.
    for (const Json& m : json["materials"])
        for (const Json& v : m.value("emissiveFactor", Json::array())) EXPECT_LE(v.get<double>(), 1.0);
    const Json& used = json["extensionsUsed"];
    EXPECT_NE(std::find(used.begin(), used.end(), "KHR_materials_emissive_strength"), used.end());
    EXPECT_EQ(readImage(out / "textures/a%2Fb.baseColor.png").alpha, readImage(f.folder / "tex/a b.png").alpha);

    // Again from the export, into a third folder: names must not clash with the files that are already there.
    const TempFolder again;
    Scene second = back;
    change(second.parameters[0]);
    exportScene(second, {0}, again.path());
    expectSame(second, loadScene(again / "scene.gltf"));
}

TEST(GltfExport, NothingChangedIsTheSameScene) {
    Fixture f;
    const Scene s = loadScene(f.w.write(f.folder));
    const TempFolder out;
    exportScene(s, {}, out.path());
    expectSame(s, loadScene(out / "scene.gltf"));
    EXPECT_EQ(readText(out / "tex/a b.png"), readText(f.folder / "tex/a b.png"));
    EXPECT_EQ(readText(out / "sky.exr"), readText(f.folder / "sky.exr"));
}

TEST(GltfExport, DimEmissionNeedsNoExtension) {
    Fixture f;
    Scene s = loadScene(f.w.write(f.folder));
    for (const char* name : {"a/b.emission", "plain.emission"}) {
        Parameter& p = s.parameters[s.parameter(name)];
        p.materialise();
        for (std::size_t i = 0; i < p.values.size(); ++i) p.values[i] = 0.01f * float(i % 3);
    }
    const TempFolder out;
    exportScene(s, {s.parameter("a/b.emission"), s.parameter("plain.emission")}, out.path());
    expectSame(s, loadScene(out / "scene.gltf"));
    EXPECT_EQ(readText(out / "scene.gltf").find("emissive_strength"), std::string::npos);
}

TEST(GltfExport, GlassLoadsBack) {
    Fixture f;
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.4}}},
                                {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}, {"KHR_materials_volume", {{"thicknessFactor", 1}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    ASSERT_EQ(s.materials[1].model, SurfaceModel::Dielectric);
    std::vector<std::uint32_t> changed;
    for (const char* name : {"plain.baseColor", "plain.specular", "plain.roughness"}) {
        changed.push_back(s.parameter(name));
        change(s.parameters[changed.back()]);
    }
    EXPECT_EQ(s.parameters[changed[1]].values.size(), 3u);
    const TempFolder out;
    exportScene(s, changed, out.path());
    const Scene back = loadScene(out / "scene.gltf");
    expectSame(s, back);
    EXPECT_EQ(back.materials[1].model, SurfaceModel::Dielectric);

    const std::uint32_t metallic = s.parameter("plain.metallic"); // which glass does not read
    s.parameters[metallic].values[0] = 1;
    const TempFolder again;
    exportScene(s, {metallic}, again.path());
    EXPECT_EQ(loadScene(again / "scene.gltf").materials[1].model, SurfaceModel::Dielectric);
}

TEST(GltfExport, TexturesOfWhatGlassReflectsLoadBack) {
    Fixture f;
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.4}}},
                                {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}, {"KHR_materials_volume", {{"thicknessFactor", 1}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    const std::uint32_t specular = s.parameter("plain.specular");
    Parameter& p = s.parameters[specular];
    p.width = 2;
    p.height = 1;
    p.textured = true;
    p.values = {1, 0.5f, 0.25f, 0, 0.75f, 0.125f};
    const TempFolder out;
    exportScene(s, {specular}, out.path());
    expectSame(s, loadScene(out / "scene.gltf"));
}

TEST(GltfExport, PartialTransmissionLoadsBack) {
    Fixture f;
    const auto& texture = f.w.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    const Json pbr = {{"metallicFactor", 0}, {"roughnessFactor", 0.4}};
    for (const Json& transmission : {Json{{"transmissionFactor", 0.3}}, Json{{"transmissionFactor", 0.5}, {"transmissionTexture", texture}}}) {
        f.w.json["materials"][1] = {{"name", "plain"}, {"pbrMetallicRoughness", pbr}, {"extensions", {{"KHR_materials_transmission", transmission}}}};
        Scene s = loadScene(f.w.write(f.folder));
        ASSERT_NE(s.materials[1].blendWith, kNoMaterial);
        const std::uint32_t weight = s.parameter("plain.transmission");
        change(s.parameters[weight]);
        const TempFolder out;
        exportScene(s, {weight}, out.path());
        const Scene back = loadScene(out / "scene.gltf");
        expectSame(s, back);
        EXPECT_NE(back.materials[1].blendWith, kNoMaterial);
    }
}

// Metal lets no light through in glTF: the factor is of what is left beside it.
TEST(GltfExport, PartialTransmissionOfPartialMetalLoadsBack) {
    Fixture f;
    const auto& texture = f.w.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    for (const int textures : {0, 1, 2, 3}) { // of metal 1, of transmission 2
        Json pbr = {{"metallicFactor", 0.5}, {"roughnessFactor", 0.4}}, transmission = {{"transmissionFactor", 0.5}};
        if (textures & 1) pbr["metallicRoughnessTexture"] = texture;
        if (textures & 2) transmission["transmissionTexture"] = texture;
        f.w.json["materials"][1] = {{"name", "plain"}, {"pbrMetallicRoughness", pbr}, {"extensions", {{"KHR_materials_transmission", transmission}}}};
        for (const bool byMetal : {false, true}) { // which of the two is recovered
            SCOPED_TRACE(testing::Message() << textures << byMetal);
            Scene s = loadScene(f.w.write(f.folder));
            ASSERT_NE(s.materials[1].blendWith, kNoMaterial);
            const std::uint32_t weight = s.parameter("plain.transmission"), metallic = s.parameter("plain.metallic"), changed = byMetal ? metallic : weight;
            for (const std::uint32_t p : {weight, metallic}) s.parameters[p].materialise();
            for (float& v : s.parameters[changed].values) v = byMetal ? v * 0.3f : 0.4f;
            std::vector<float> &w = s.parameters[weight].values, &m = s.parameters[metallic].values;
            for (std::size_t i = 0; i < w.size(); ++i) w[i] = std::min(w[i], 1 - m[m.size() > 1 ? i : 0]);
            const TempFolder out;
            exportScene(s, {changed}, out.path());
            expectSame(s, loadScene(out / "scene.gltf"));
        }
    }
}

TEST(GltfExport, TransmissionThatMetalLeavesNoRoomForIsCut) {
    Fixture f;
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"pbrMetallicRoughness", {{"metallicFactor", 0.5}}},
                                {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.8}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    const std::uint32_t weight = s.parameter("plain.transmission"), metallic = s.parameter("plain.metallic");
    s.parameters[metallic].values = {0.9f};
    std::string said;
    setLogListener([&](LogLevel, std::string_view, std::string_view message) { said += message; });
    const TempFolder out;
    exportScene(s, {metallic}, out.path());
    setLogListener({});
    EXPECT_NE(said.find("plain.transmission"), std::string::npos) << said;
    const Scene back = loadScene(out / "scene.gltf");
    EXPECT_NEAR(valuesOf(back, "plain.transmission")[0], 0.1f, 1e-6f);
    EXPECT_EQ(valuesOf(back, "plain.metallic")[0], 0.9f);
    s.parameters[metallic].values = {1.0f};
    const TempFolder all;
    exportScene(s, {weight, metallic}, all.path());
    const Json json = Json::parse(readText(all / "scene.gltf"));
    EXPECT_EQ(json["materials"][1]["extensions"]["KHR_materials_transmission"]["transmissionFactor"], Json(0.0));
}

TEST(GltfExport, MetalsThatWereOpaqueStayOpaque) {
    Fixture f;
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"pbrMetallicRoughness", {{"metallicFactor", 1}}},
                                {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.8}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    ASSERT_EQ(s.materials[1].blendWith, kNoMaterial);
    s.parameters[s.parameter("plain.metallic")].values = {0.5f};
    const TempFolder out;
    exportScene(s, {s.parameter("plain.metallic")}, out.path());
    const Scene back = loadScene(out / "scene.gltf");
    expectSame(s, back);
    EXPECT_EQ(back.materials[1].blendWith, kNoMaterial);
}

// Roughness brings a texture in which metal, a constant, has a place: the weight has one, too.
TEST(GltfExport, TransmissionBesideAResizedRoughnessLoadsBack) {
    Fixture f;
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"pbrMetallicRoughness", {{"metallicFactor", 0.5}}},
                                {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.5}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    Parameter& roughness = s.parameters[s.parameter("plain.roughness")];
    roughness.width = roughness.height = 2;
    roughness.textured = true;
    roughness.values = {0.25f, 0.5f, 0.75f, 1};
    const TempFolder out;
    exportScene(s, {s.parameter("plain.roughness")}, out.path());
    for (const float v : valuesOf(loadScene(out / "scene.gltf"), "plain.transmission")) EXPECT_NEAR(v, 0.25f, 0.505f / 255);
}

TEST(GltfExport, TexturesThatAreNotReadLeaveTheirSlots) {
    Fixture f;
    const Json unread = {{"index", 1}, {"texCoord", 1}};
    f.w.json["textures"].push_back({{"sampler", 0}, {"extensions", {{"EXT_texture_webp", {{"source", 0}}}}}});
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"pbrMetallicRoughness", {{"baseColorTexture", unread}, {"metallicRoughnessTexture", unread}, {"metallicFactor", 0}}},
                                {"emissiveTexture", unread},
                                {"emissiveFactor", {1, 1, 1}},
                                {"normalTexture", unread},
                                {"occlusionTexture", unread},
                                {"extensions",
                                 {{"KHR_materials_specular", {{"specularTexture", unread}}},
                                  {"KHR_materials_transmission", {{"transmissionFactor", 0.5}, {"transmissionTexture", unread}}},
                                  {"KHR_materials_clearcoat", {{"clearcoatFactor", 0.5}, {"clearcoatTexture", unread}, {"clearcoatRoughnessTexture", unread}}},
                                  {"KHR_materials_sheen", {{"sheenColorFactor", {1, 1, 1}}, {"sheenColorTexture", unread}, {"sheenRoughnessTexture", unread}}},
                                  {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}, {"anisotropyTexture", unread}}}}}};
    for (const bool texels : {false, true}) { // a constant may have become a texture
        Scene s = loadScene(f.w.write(f.folder));
        EXPECT_TRUE(warned(s, "no image in a format that is read"));
        std::vector<std::uint32_t> changed;
        for (const std::uint32_t p : s.materials[1].parameters) {
            if (p == kNoParameter || (texels && s.parameters[p].kind == SlotKind::Weight)) continue;
            Parameter& parameter = s.parameters[p];
            ASSERT_FALSE(parameter.textured) << parameter.name;
            if (texels && parameter.kind != SlotKind::Normal) {
                parameter.width = parameter.height = 2;
                parameter.textured = true;
                parameter.values.resize(parameter.entries());
            }
            change(parameter);
            if (parameter.kind == SlotKind::Metallic) parameter.values.assign(parameter.values.size(), 0.0f);
            if (parameter.kind == SlotKind::Normal) parameter.values = {0, 0, 1};
            changed.push_back(p);
        }
        const TempFolder out;
        exportScene(s, changed, out.path());
        const Scene back = loadScene(out / "scene.gltf");
        for (const std::uint32_t p : changed) {
            const Parameter& parameter = s.parameters[p];
            const std::vector<float> is = valuesOf(back, parameter.name);
            ASSERT_EQ(is.size(), parameter.values.size()) << parameter.name;
            const float brightest = *std::max_element(is.begin(), is.end()), largest = parameter.kind == SlotKind::Emission ? brightest : 1.0f;
            for (std::size_t i = 0; i < is.size(); ++i) EXPECT_NEAR(is[i], parameter.values[i], tolerance(parameter, parameter.values[i], largest)) << parameter.name;
        }
        Json material = Json::parse(readText(out / "scene.gltf"))["materials"][1];
        EXPECT_TRUE(material.contains("occlusionTexture")) << "of no slot";
        material.erase("occlusionTexture");
        EXPECT_EQ(material.dump().find(unread.dump()), std::string::npos) << material.dump(1);
    }
    // What is left alone stays.
    const TempFolder out;
    Scene s = loadScene(f.w.write(f.folder));
    exportScene(s, {s.parameter("plain.baseColor")}, out.path());
    EXPECT_TRUE(Json::parse(readText(out / "scene.gltf"))["materials"][1].contains("emissiveTexture"));
}

TEST(GltfExport, OtherExtrasStayBesideANewEnvironment) {
    Fixture f;
    f.w.json["scenes"][0]["extras"] = "a note";
    LoadOptions options;
    options.environment.file = f.folder / "sky.exr";
    const Scene s = loadScene(f.w.write(f.folder), options);
    const TempFolder out;
    exportScene(s, {}, out.path());
    EXPECT_TRUE(loadScene(out / "scene.gltf").environment);
    EXPECT_EQ(Json::parse(readText(out / "scene.gltf"))["scenes"][0]["extras"]["extras"], Json("a note"));
}

// Whichever two sets of texture coordinates a material names.
TEST(GltfExport, HigherTextureCoordinatesStay) {
    Fixture f;
    Json& attributes = primitive(f.w)["attributes"];
    attributes["TEXCOORD_2"] = f.w.floats({0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f}, 2);
    attributes["TEXCOORD_5"] = f.w.floats({0.9f, 0.8f, 0.7f, 0.6f, 0.5f, 0.4f}, 2);
    Json& material = f.w.json["materials"][0];
    for (Json* texture : {&material["pbrMetallicRoughness"]["baseColorTexture"], &material["normalTexture"], &material["emissiveTexture"]}) (*texture)["texCoord"] = 2;
    for (Json* texture : {&material["pbrMetallicRoughness"]["metallicRoughnessTexture"], &material["extensions"]["KHR_materials_specular"]["specularTexture"]})
        (*texture)["extensions"]["KHR_texture_transform"]["texCoord"] = 5;
    Scene s = loadScene(f.w.write(f.folder));
    const auto at = [](const Scene& scene, const char* name) {
        const Parameter& p = find(scene, name);
        const Triangle& t = scene.geometry.triangles[0];
        return (p.texcoord == 0 ? scene.geometry.uv0 : scene.geometry.uv1)[t.vertices[1]];
    };
    std::vector<std::uint32_t> changed;
    for (const char* name : {"a/b.baseColor", "a/b.roughness", "a/b.normal"}) {
        changed.push_back(s.parameter(name));
        change(s.parameters[changed.back()]);
    }
    const TempFolder out;
    exportScene(s, changed, out.path());
    const Scene back = loadScene(out / "scene.gltf");
    expectSame(s, back);
    for (const Scene* scene : std::initializer_list<const Scene*>{&s, &back}) {
        for (const char* name : {"a/b.baseColor", "a/b.normal", "a/b.emission"}) EXPECT_EQ(at(*scene, name), glm::vec2(0.3f, 0.4f)) << name;
        for (const char* name : {"a/b.roughness", "a/b.metallic", "a/b.specular"}) EXPECT_EQ(at(*scene, name), glm::vec2(0.7f, 0.6f)) << name;
        EXPECT_FALSE(warned(*scene, "TEXCOORD"));
    }
}

// A third set is not read; what is written has the one that was.
TEST(GltfExport, MoreTextureCoordinatesThanAreReadAreWrittenAsRead) {
    Fixture f;
    Json& material = f.w.json["materials"][0];
    material["normalTexture"]["texCoord"] = 1;
    for (Json* texture : {&material["pbrMetallicRoughness"]["baseColorTexture"], &material["emissiveTexture"]}) {
        (*texture)["texCoord"] = 2;
        (*texture)["extensions"]["KHR_texture_transform"]["texCoord"] = 3;
    }
    material["emissiveTexture"]["extensions"]["KHR_texture_transform"].erase("texCoord");
    Scene s = loadScene(f.w.write(f.folder));
    EXPECT_TRUE(warned(s, "a/b.baseColor: its texture is used with TEXCOORD_3"));
    std::vector<std::uint32_t> changed;
    for (const char* name : {"a/b.baseColor", "a/b.emission"}) {
        changed.push_back(s.parameter(name));
        EXPECT_EQ(s.parameters[changed.back()].texcoord, 0u);
        change(s.parameters[changed.back()]);
    }
    const TempFolder out;
    exportScene(s, changed, out.path());
    const Scene back = loadScene(out / "scene.gltf");
    EXPECT_FALSE(warned(back, "TEXCOORD"));
    for (const char* name : {"a/b.baseColor", "a/b.emission"}) EXPECT_EQ(find(back, name).texcoord, 0u) << name;
}

// Exact values of an earlier run are where a user goes on from.
TEST(GltfExport, CopiesLeaveExactValuesAlone) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    fs::create_directories(folder / "parameters");
    saveExr(folder / "parameters/wall.baseColor.exr", 2, 1, "RGB", std::vector<float>(6, 0.25f));
    w.json["images"] = {{{"uri", "parameters/wall.baseColor.exr"}}};
    w.json["textures"] = {{{"source", 0}}};
    for (const char* name : {"wall", "other"})
        w.json["materials"][name == std::string("wall") ? 0 : 1] = {{"name", name}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}};
    Scene s = loadScene(w.write(folder, "first.gltf"));
    const std::uint32_t wall = s.parameter("wall.baseColor");
    s.parameters[wall].materialise();
    const std::vector<float> values(6, 0.123456f);
    s.parameters[wall].values = values;
    const TempFolder out;
    exportScene(s, {wall}, out.path());
    EXPECT_EQ(readImage(out / "parameters/wall.baseColor.exr").image.values, values);
    EXPECT_EQ(valuesOf(loadScene(out / "scene.gltf"), "other.baseColor"), std::vector<float>(6, 0.25f));
    // Nor are files overwritten that the scene is read from, whatever its own name.
    const std::string before = readText(folder / "parameters/wall.baseColor.exr");
    EXPECT_THROW(exportScene(s, {wall}, folder.path()), Error);
    EXPECT_EQ(readText(folder / "parameters/wall.baseColor.exr"), before);
    exportScene(s, {}, folder.path()); // which has another name
    EXPECT_EQ(valuesOf(loadScene(folder / "scene.gltf"), "wall.baseColor"), std::vector<float>(6, 0.25f));
}

// Textures that are written into the scene's own folder go beside those that are read there.
TEST(GltfExport, TexturesOfTheSceneItselfStay) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    savePng(folder / "textures/wall.baseColor.png", 1, 2, 3, {255, 0, 0, 0, 255, 0});
    w.json["images"] = {{{"uri", "textures/wall.baseColor.png"}}};
    w.json["textures"] = {{{"source", 0}}};
    w.json["materials"][0] = {{"name", "wall"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}};
    Scene s = loadScene(w.write(folder, "first.gltf"));
    Parameter& wall = s.parameters[s.parameter("wall.baseColor")];
    wall.materialise();
    wall.values.assign(6, 1.0f);
    const std::string before = readText(folder / "textures/wall.baseColor.png");
    exportScene(s, {s.parameter("wall.baseColor")}, folder.path());
    EXPECT_EQ(readText(folder / "textures/wall.baseColor.png"), before);
    EXPECT_EQ(valuesOf(loadScene(folder / "scene.gltf"), "wall.baseColor"), std::vector<float>(6, 1.0f));
}

TEST(GltfExport, NamesWithColonsStay) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    savePng(folder / "tex:a.png", 1, 1, 3, {255, 0, 0});
    w.json["images"] = {{{"uri", "tex%3Aa.png"}}};
    w.json["textures"] = {{{"source", 0}}};
    w.json["materials"][0] = {{"name", "wall"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}};
    const Scene s = loadScene(w.write(folder));
    const TempFolder out;
    exportScene(s, {}, out.path());
    EXPECT_EQ(readText(out / "tex:a.png"), readText(folder / "tex:a.png"));
    EXPECT_EQ(valuesOf(loadScene(out / "scene.gltf"), "wall.baseColor"), (std::vector<float>{1, 0, 0}));
}

TEST(GltfExport, ClearCoatLoadsBack) {
    Fixture f;
    const auto& texture = f.w.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"extensions", {{"KHR_materials_clearcoat", {{"clearcoatFactor", 0.5}, {"clearcoatRoughnessFactor", 0.4}, {"clearcoatRoughnessTexture", texture}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    std::vector<std::uint32_t> changed;
    for (const char* name : {"plain.clearcoat", "plain.clearcoatRoughness"}) {
        changed.push_back(s.parameter(name));
        change(s.parameters[changed.back()]);
    }
    ASSERT_TRUE(s.parameters[changed[1]].textured);
    const TempFolder out;
    exportScene(s, changed, out.path());
    expectSame(s, loadScene(out / "scene.gltf"));
}

// A coat's own normals stay as they are; those that it shares with the surface change with them.
TEST(GltfExport, NormalsOfClearCoatsLoadBack) {
    Fixture f;
    const Json map = {{"index", 0}, {"texCoord", 1}};
    for (const bool shared : {false, true}) {
        Json& material = f.w.json["materials"][1];
        material = {{"name", "plain"}, {"extensions", {{"KHR_materials_clearcoat", {{"clearcoatFactor", 0.5}, {"clearcoatNormalTexture", map}}}}}};
        material["normalTexture"] = shared ? map : Json{{"index", 0}, {"scale", 0.5}};
        Scene s = loadScene(f.w.write(f.folder));
        ASSERT_EQ(hasClearcoatNormals(s.materials[1]), !shared);
        std::vector<std::uint32_t> changed;
        for (const char* name : {"plain.normal", "plain.clearcoat"}) {
            changed.push_back(s.parameter(name));
            change(s.parameters[changed.back()]);
        }
        const TempFolder out;
        exportScene(s, changed, out.path());
        const Scene back = loadScene(out / "scene.gltf");
        expectSame(s, back);
        ASSERT_EQ(hasClearcoatNormals(back.materials[1]), !shared);
        ASSERT_EQ(back.directionTextures.size(), s.directionTextures.size());
        if (!shared) {
            EXPECT_EQ(back.directionTextures[0].directions, s.directionTextures[0].directions);
        }
    }
}

// Both are read from one image, and become two.
TEST(GltfExport, SheenLoadsBack) {
    Fixture f;
    const auto& texture = f.w.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"extensions", {{"KHR_materials_sheen", {{"sheenColorFactor", {0.5, 1, 0.75}}, {"sheenColorTexture", texture}, {"sheenRoughnessFactor", 0.4}}}}}};
    for (const bool textured : {false, true}) {
        if (textured)
            f.w.json["materials"][1]["extensions"]["KHR_materials_sheen"]["sheenRoughnessTexture"] = texture;
        Scene s = loadScene(f.w.write(f.folder));
        std::vector<std::uint32_t> changed;
        for (const char* name : {"plain.sheenColor", "plain.sheenRoughness"}) {
            changed.push_back(s.parameter(name));
            change(s.parameters[changed.back()]);
        }
        ASSERT_TRUE(s.parameters[changed[0]].textured);
        const TempFolder out;
        exportScene(s, changed, out.path());
        expectSame(s, loadScene(out / "scene.gltf"));
    }
}

TEST(GltfExport, AnisotropyLoadsBack) {
    Fixture f;
    const auto& texture = f.w.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    f.w.json["materials"][1] = {{"name", "plain"}, {"extensions", {{"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}, {"anisotropyRotation", 0.3}, {"anisotropyTexture", texture}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    const std::uint32_t strength = s.parameter("plain.anisotropy");
    change(s.parameters[strength]);
    ASSERT_TRUE(s.parameters[strength].textured);
    const TempFolder out;
    exportScene(s, {strength}, out.path());
    const Scene back = loadScene(out / "scene.gltf");
    expectSame(s, back);
    ASSERT_EQ(back.directionTextures.size(), 1u);
    EXPECT_EQ(back.directionTextures[0].directions, s.directionTextures[0].directions);
}

TEST(GltfExport, BinaryScenesBecomeTextAndData) {
    const TempFolder folder, out;
    GltfWriter w = oneTriangle();
    writeText(folder / "s.glb", w.glb());
    Scene s = loadScene(folder / "s.glb");
    s.parameters[0].values = {0.25f, 0.5f, 0.75f};
    exportScene(s, {0}, out.path());
    const Scene back = loadScene(out / "scene.gltf");
    expectSame(s, back);
    EXPECT_EQ(back.geometry.positions, s.geometry.positions);
    EXPECT_EQ(back.materials.size(), 1u);
}

TEST(GltfExport, RefusesToOverwriteItsSource) {
    Fixture f;
    const Scene s = loadScene(f.w.write(f.folder));
    try {
        exportScene(s, {}, f.folder.path());
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(e.kind, ErrorKind::Output);
    }
    EXPECT_NO_THROW(loadScene(f.folder / "scene.gltf"));
}

TEST(ExportFolder, FileNamesAreSafe) {
    EXPECT_EQ(fileName("wall.baseColor"), "wall.baseColor");
    EXPECT_EQ(fileName("../a/b\n.normal").find_first_of("/\\\n"), std::string::npos);
    EXPECT_NE(fileName("a/b.normal"), fileName("a:b.normal")); // no two parameters share a file
    EXPECT_EQ(fileName("Wall (2) #3_a-b%.baseColor"), "Wall (2) #3_a-b%25.baseColor");
    EXPECT_EQ(fileName("a~b*?\"<>|\\\x7f.normal"), "a%7Eb%2A%3F%22%3C%3E%7C%5C%7F.normal");
    EXPECT_EQ(fileName(".hidden.normal"), "%2Ehidden.normal");
}

TEST(ExportFolder, FileNamesKeepLetters) {
    EXPECT_EQ(fileName("Wände.baseColor"), "Wände.baseColor");
    EXPECT_EQ(fileName("木の床 🪵.baseColor"), "木の床 🪵.baseColor");
    EXPECT_EQ(fileName("a\xff\xc3.normal"), "a%FF%C3.normal") << "no UTF-8";
    EXPECT_EQ(fileName("\xc0\xaf\xed\xa0\x80\xf4\x90\x80\x80"), "%C0%AF%ED%A0%80%F4%90%80%80") << "a longer form, half a pair, beyond the last";
    EXPECT_EQ(fileName("a\u0085\u202e\u200b\ufeff.normal"), "a%C2%85%E2%80%AE%E2%80%8B%EF%BB%BF.normal") << "not to be seen";
}

TEST(ExportFolder, FileNamesAreShort) {
    constexpr std::size_t kMost = 120;
    const std::string many(110, 'x');
    EXPECT_EQ(fileName(many + ".baseColor"), many + ".baseColor");
    std::set<std::string> names;
    for (const std::string& beginning : {std::string(300, 'x'), std::string(300, 'x') + "y", std::string(50, '/'), std::string(50, '!') + '/'})
        for (const char* slot : {".baseColor", ".normal"}) {
            const std::string name = fileName(beginning + slot);
            EXPECT_LE(name.size(), kMost) << name;
            EXPECT_TRUE(name.ends_with(slot)) << name;
            EXPECT_EQ(std::count(name.begin(), name.end(), '%') * 3 + std::count(name.begin(), name.end(), 'x') + 17 + std::ptrdiff_t(std::strlen(slot)),
                      std::ptrdiff_t(name.size())) << "whole codes: " << name;
            names.insert(name);
        }
    EXPECT_EQ(names.size(), 8u);
    for (std::size_t shift = 0; shift < 4; ++shift) { // cut between characters
        std::string name(shift, 'x');
        for (int i = 0; i < 100; ++i) name += "床";
        const std::string cut = fileName(name + ".baseColor");
        EXPECT_LE(cut.size(), kMost);
        EXPECT_EQ((cut.find('~') - shift) % 3, 0u) << cut;
    }
    EXPECT_LE(fileName("a." + std::string(400, 'z')).size(), kMost);
}

TEST(ExportFolder, LongNamesAreWritten) {
    const TempFolder folder;
    GltfWriter w = oneTriangle();
    std::string name;
    for (int i = 0; i < 80; ++i) name += "床"; // 240 bytes, and 720 percent-encoded
    w.json["materials"] = {{{"name", name}}};
    primitive(w)["material"] = 0;
    Scene s = loadScene(w.write(folder));
    const std::uint32_t index = s.parameter(name + ".baseColor");
    s.parameters[index].values = {0.25f, 0.5f, 0.75f};
    const TempFolder out;
    exportScene(s, {index}, out.path());
    EXPECT_EQ(readImage(out / ("parameters/" + fileName(name + ".baseColor") + ".exr")).image.values, s.parameters[index].values);
    EXPECT_EQ(valuesOf(loadScene(out / "scene.gltf"), name + ".baseColor"), s.parameters[index].values);

    // As long as a name may be, though it is written under another one first.
    const fs::path file = out / (std::string(251, 'x') + ".txt");
    const std::uint8_t byte = 'a';
    writeFile(file, std::span(&byte, 1));
    EXPECT_EQ(readText(file), "a");
}

} // namespace
} // namespace cmpg::test

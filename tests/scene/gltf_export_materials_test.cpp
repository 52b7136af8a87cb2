// Export of what materials have: changed parameters of each extension load back with the same values.
#include "base/log.h"
#include "gltf_export.h"
#include "scene/file_io.h"

namespace cmpg::test {
namespace {

TEST(GltfExport, DimEmissionNeedsNoExtension) {
    ExportedScene f;
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
    ExportedScene f;
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0.4}}},
                                {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}, {"KHR_materials_volume", {{"thicknessFactor", 1}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    ASSERT_EQ(s.materials[1].model, SurfaceModel::Dielectric);
    const std::vector<std::uint32_t> changed = changeNamed(s, {"plain.baseColor", "plain.specular", "plain.roughness"});
    EXPECT_EQ(s.parameters[changed[1]].values.size(), 3u);
    const Scene back = loadedBack(s, changed);
    EXPECT_EQ(back.materials[1].model, SurfaceModel::Dielectric);

    const std::uint32_t metallic = s.parameter("plain.metallic"); // which glass does not read
    s.parameters[metallic].values[0] = 1;
    const TempFolder again;
    exportScene(s, {metallic}, again.path());
    EXPECT_EQ(loadScene(again / "scene.gltf").materials[1].model, SurfaceModel::Dielectric);
}

TEST(GltfExport, TexturesOfWhatGlassReflectsLoadBack) {
    ExportedScene f;
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
    loadedBack(s, {specular});
}

TEST(GltfExport, PartialTransmissionLoadsBack) {
    ExportedScene f;
    const auto& texture = f.w.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    const Json pbr = {{"metallicFactor", 0}, {"roughnessFactor", 0.4}};
    for (const Json& transmission : {Json{{"transmissionFactor", 0.3}}, Json{{"transmissionFactor", 0.5}, {"transmissionTexture", texture}}}) {
        f.w.json["materials"][1] = {{"name", "plain"}, {"pbrMetallicRoughness", pbr}, {"extensions", {{"KHR_materials_transmission", transmission}}}};
        Scene s = loadScene(f.w.write(f.folder));
        ASSERT_NE(s.materials[1].blendWith, kNoMaterial);
        const std::uint32_t weight = s.parameter("plain.transmission");
        change(s.parameters[weight]);
        const Scene back = loadedBack(s, {weight});
        EXPECT_NE(back.materials[1].blendWith, kNoMaterial);
    }
}

// Metal lets no light through in glTF: the factor is of what is left beside it.
TEST(GltfExport, PartialTransmissionOfPartialMetalLoadsBack) {
    ExportedScene f;
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
            loadedBack(s, {changed});
        }
    }
}

TEST(GltfExport, TransmissionThatMetalLeavesNoRoomForIsCut) {
    ExportedScene f;
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
    ExportedScene f;
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"pbrMetallicRoughness", {{"metallicFactor", 1}}},
                                {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 0.8}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    ASSERT_EQ(s.materials[1].blendWith, kNoMaterial);
    s.parameters[s.parameter("plain.metallic")].values = {0.5f};
    const Scene back = loadedBack(s, {s.parameter("plain.metallic")});
    EXPECT_EQ(back.materials[1].blendWith, kNoMaterial);
}

// Roughness brings a texture in which metal, a constant, has a place: the weight has one, too.
TEST(GltfExport, TransmissionBesideAResizedRoughnessLoadsBack) {
    ExportedScene f;
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
    ExportedScene f;
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

TEST(GltfExport, ClearCoatLoadsBack) {
    ExportedScene f;
    const auto& texture = f.w.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"extensions", {{"KHR_materials_clearcoat", {{"clearcoatFactor", 0.5}, {"clearcoatRoughnessFactor", 0.4}, {"clearcoatRoughnessTexture", texture}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    const std::vector<std::uint32_t> changed = changeNamed(s, {"plain.clearcoat", "plain.clearcoatRoughness"});
    ASSERT_TRUE(s.parameters[changed[1]].textured);
    loadedBack(s, changed);
}

// A coat's own normals stay as they are; those that it shares with the surface change with them.
TEST(GltfExport, NormalsOfClearCoatsLoadBack) {
    ExportedScene f;
    const Json map = {{"index", 0}, {"texCoord", 1}};
    for (const bool shared : {false, true}) {
        Json& material = f.w.json["materials"][1];
        material = {{"name", "plain"}, {"extensions", {{"KHR_materials_clearcoat", {{"clearcoatFactor", 0.5}, {"clearcoatNormalTexture", map}}}}}};
        material["normalTexture"] = shared ? map : Json{{"index", 0}, {"scale", 0.5}};
        Scene s = loadScene(f.w.write(f.folder));
        ASSERT_EQ(hasClearcoatNormals(s.materials[1]), !shared);
        const std::vector<std::uint32_t> changed = changeNamed(s, {"plain.normal", "plain.clearcoat"});
        const Scene back = loadedBack(s, changed);
        ASSERT_EQ(hasClearcoatNormals(back.materials[1]), !shared);
        ASSERT_EQ(back.directionTextures.size(), s.directionTextures.size());
        if (!shared) {
            EXPECT_EQ(back.directionTextures[0].directions, s.directionTextures[0].directions);
        }
    }
}

// Both are read from one image, and become two.
TEST(GltfExport, SheenLoadsBack) {
    ExportedScene f;
    const auto& texture = f.w.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    f.w.json["materials"][1] = {{"name", "plain"},
                                {"extensions", {{"KHR_materials_sheen", {{"sheenColorFactor", {0.5, 1, 0.75}}, {"sheenColorTexture", texture}, {"sheenRoughnessFactor", 0.4}}}}}};
    for (const bool textured : {false, true}) {
        if (textured)
            f.w.json["materials"][1]["extensions"]["KHR_materials_sheen"]["sheenRoughnessTexture"] = texture;
        Scene s = loadScene(f.w.write(f.folder));
        const std::vector<std::uint32_t> changed = changeNamed(s, {"plain.sheenColor", "plain.sheenRoughness"});
        ASSERT_TRUE(s.parameters[changed[0]].textured);
        loadedBack(s, changed);
    }
}

TEST(GltfExport, AnisotropyLoadsBack) {
    ExportedScene f;
    const auto& texture = f.w.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    f.w.json["materials"][1] = {{"name", "plain"}, {"extensions", {{"KHR_materials_anisotropy", {{"anisotropyStrength", 0.5}, {"anisotropyRotation", 0.3}, {"anisotropyTexture", texture}}}}}};
    Scene s = loadScene(f.w.write(f.folder));
    const std::uint32_t strength = s.parameter("plain.anisotropy");
    change(s.parameters[strength]);
    ASSERT_TRUE(s.parameters[strength].textured);
    const Scene back = loadedBack(s, {strength});
    ASSERT_EQ(back.directionTextures.size(), 1u);
    EXPECT_EQ(back.directionTextures[0].directions, s.directionTextures[0].directions);
}

} // namespace
} // namespace cmpg::test

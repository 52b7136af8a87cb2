// Export: a scene written with changed parameters loads back with the same values, beside all that export does not change.
#include "gltf_export.h"
#include "scene/file_io.h"
#include "scene/image.h"

namespace cmpg::test {
namespace {

TEST(GltfExport, EveryChangedSlotLoadsBack) {
    ExportedScene f;
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
    ExportedScene f;
    const Scene s = loadScene(f.w.write(f.folder));
    const TempFolder out;
    exportScene(s, {}, out.path());
    expectSame(s, loadScene(out / "scene.gltf"));
    EXPECT_EQ(readText(out / "tex/a b.png"), readText(f.folder / "tex/a b.png"));
    EXPECT_EQ(readText(out / "sky.exr"), readText(f.folder / "sky.exr"));
}

TEST(GltfExport, OtherExtrasStayBesideANewEnvironment) {
    ExportedScene f;
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
    ExportedScene f;
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
    const std::vector<std::uint32_t> changed = changeNamed(s, {"a/b.baseColor", "a/b.roughness", "a/b.normal"});
    const Scene back = loadedBack(s, changed);
    for (const Scene* scene : std::initializer_list<const Scene*>{&s, &back}) {
        for (const char* name : {"a/b.baseColor", "a/b.normal", "a/b.emission"}) EXPECT_EQ(at(*scene, name), glm::vec2(0.3f, 0.4f)) << name;
        for (const char* name : {"a/b.roughness", "a/b.metallic", "a/b.specular"}) EXPECT_EQ(at(*scene, name), glm::vec2(0.7f, 0.6f)) << name;
        EXPECT_FALSE(warned(*scene, "TEXCOORD"));
    }
}

// A third set is not read; what is written has the one that was.
TEST(GltfExport, MoreTextureCoordinatesThanAreReadAreWrittenAsRead) {
    ExportedScene f;
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
    ExportedScene f;
    const Scene s = loadScene(f.w.write(f.folder));
    try {
        exportScene(s, {}, f.folder.path());
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(e.kind, ErrorKind::Output);
    }
    EXPECT_NO_THROW(loadScene(f.folder / "scene.gltf"));
}

} // namespace
} // namespace cmpg::test

// Other sizes of parameters: what has no place for a texture, and that what is exported loads back.
#include "scene/parameter_size.h"

#include "mitsuba_scene.h"
#include "scene/export_folder.h"
#include "test_images.h"

namespace cmpg::test {
namespace {

Scene square(const TempFolder& folder, const std::string& more = "") { return loadText(folder, kSquare + more); }

TEST(ParameterSize, AConstantBecomesATextureThatMitsubaReads) {
    const TempFolder folder, out;
    Scene s = square(folder);
    const std::uint32_t wall = s.parameter("wall.reflectance");
    resize(s, wall, 4, 2);
    EXPECT_TRUE(s.parameters[wall].textured);
    ASSERT_EQ(s.parameters[wall].values.size(), 4u * 2 * 3);
    for (std::size_t i = 0; i < 24; ++i)
        EXPECT_EQ(s.parameters[wall].values[i], 0.1f * float(i % 3 + 1)) << i;
    for (std::size_t i = 0; i < 24; ++i)
        s.parameters[wall].values[i] = float(i) / 24;
    exportScene(s, {wall}, out.path());
    const Scene back = loadScene(out / "scene.xml");
    const Parameter& read = find(back, "wall.reflectance");
    EXPECT_EQ(glm::uvec2(read.width, read.height), glm::uvec2(4, 2));
    const std::vector<float> values = valuesOf(back, "wall.reflectance");
    for (std::size_t i = 0; i < 24; ++i)
        EXPECT_NEAR(values[i], float(i) / 24, 0.01f) << i;
}

// A triangle with texture coordinates and one without, a mask, and constants.
struct Fixture {
    TempFolder folder;
    GltfWriter w = oneTriangle();
    Fixture() {
        std::vector<std::uint8_t> codes;
        for (int i = 0; i < 4 * 4; ++i)
            codes.insert(codes.end(), {200, 100, 50, std::uint8_t(16 * i)});
        savePng(folder / "mask.png", 4, 4, 4, codes);
        w.json["images"] = {{{"uri", "mask.png"}}};
        w.json["textures"] = {{{"source", 0}}};
        w.json["materials"] = {{{"name", "plain"}, {"pbrMetallicRoughness", {{"baseColorFactor", {0.25, 0.5, 0.75, 1}}, {"roughnessFactor", 0.5}, {"metallicFactor", 0.25}}}},
                               {{"name", "leaf"}, {"alphaMode", "MASK"}, {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}},
                               {{"name", "bare"}}};
        const std::size_t uv = w.floats({0, 0, 1, 0, 0, 1}, 2);
        w.json["meshes"][0]["primitives"] = {{{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", uv}}}, {"material", 0}},
                                             {{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", uv}}}, {"material", 1}},
                                             {{"attributes", {{"POSITION", 0}}}, {"material", 2}}};
    }
    Scene load() { return loadScene(w.write(folder)); }
};

void expectRefused(Scene& scene, const std::string& name, const std::string& cause) {
    try {
        resize(scene, scene.parameter(name), 8, 8);
        FAIL() << name;
    } catch (const Error& e) {
        EXPECT_EQ(e.kind, ErrorKind::Usage);
        EXPECT_NE(e.cause.find(cause), std::string::npos) << e.cause;
        EXPECT_FALSE(e.remedy.empty());
    }
}

TEST(ParameterSize, WhereNoTextureHasAPlaceIsRefused) {
    Fixture f;
    Scene s = f.load();
    expectRefused(s, "bare.baseColor", "texture coordinates");
    expectRefused(s, "plain.normal", "normal map");
    EXPECT_THROW(resize(s, s.parameter("plain.baseColor"), 0, 4), Error);
    EXPECT_THROW(resize(s, s.parameter("plain.baseColor"), 4, kMostTexels + 1), Error);
    const TempFolder folder;
    Scene lit = square(folder, "<emitter type=\"constant\"/>");
    expectRefused(lit, "environment.radiance", "one colour");
}

TEST(ParameterSize, WhatGltfExportsLoadsBack) {
    Fixture f;
    const TempFolder out;
    Scene s = f.load();
    const std::uint32_t plain = s.parameter("plain.baseColor"), rough = s.parameter("plain.roughness"), metal = s.parameter("plain.metallic"), leaf = s.parameter("leaf.baseColor");
    resize(s, plain, 4, 4);
    resize(s, rough, 8, 2); // one image has both: metallic becomes as large
    resize(s, leaf, 2, 2);
    for (std::size_t i = 0; i < 16; ++i)
        s.parameters[rough].values[i] = float(i) / 16;
    exportScene(s, {plain, rough, leaf}, out.path());
    const Scene back = loadScene(out / "scene.gltf");
    const auto sizeOf = [&](const std::string& name) { return glm::uvec2(find(back, name).width, find(back, name).height); };
    EXPECT_EQ(sizeOf("plain.baseColor"), glm::uvec2(4, 4));
    EXPECT_EQ(sizeOf("plain.roughness"), glm::uvec2(8, 2));
    EXPECT_EQ(sizeOf("plain.metallic"), glm::uvec2(8, 2));
    EXPECT_EQ(sizeOf("leaf.baseColor"), glm::uvec2(2, 2));
    const std::vector<float> colour = valuesOf(back, "plain.baseColor"), roughness = valuesOf(back, "plain.roughness");
    for (std::size_t i = 0; i < colour.size(); ++i)
        EXPECT_NEAR(colour[i], 0.25f * float(i % 3 + 1), 0.005f) << i;
    for (std::size_t i = 0; i < 16; ++i)
        EXPECT_NEAR(roughness[i], float(i) / 16, 0.002f) << i;
    for (const float v : valuesOf(back, "plain.metallic"))
        EXPECT_NEAR(v, 0.25f, 0.002f);
    // The mask keeps its alpha, in as many texels as the colour has: the means of four.
    EXPECT_EQ(readImage(out / "textures/leaf.baseColor.png").alpha, (std::vector<float>{40 / 255.f, 72 / 255.f, 168 / 255.f, 200 / 255.f}));
    EXPECT_EQ(s.parameters[metal].values, std::vector<float>{0.25f}) << "the scene itself is as it was";
}

TEST(ParameterSize, OneTexelStaysATexture) {
    Fixture f;
    const TempFolder out;
    Scene s = f.load();
    const std::uint32_t leaf = s.parameter("leaf.baseColor");
    resize(s, leaf, 1, 1);
    s.parameters[leaf].values = {0.2f, 0.4f, 0.6f};
    exportScene(s, {leaf}, out.path());
    const std::vector<float> values = valuesOf(loadScene(out / "scene.gltf"), "leaf.baseColor"); // not times the colours of the old image
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(values[c], 0.2f * float(c + 1), 0.005f);
}

} // namespace
} // namespace cmpg::test

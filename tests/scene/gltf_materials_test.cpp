// Materials of glTF scenes: what every slot's parameter holds.
#include "gltf_writer.h"
#include "scene/features.h"
#include "scene/image.h"
#include "test_images.h"

namespace cmpg::test {
namespace {

struct Fixture {
    TempFolder folder;
    GltfWriter w = oneTriangle();
    Json& material = w.json["materials"][0];

    // textures[i] of a new image; returns its index.
    std::size_t texture(const std::string& uri) {
        w.json["images"].push_back({{"uri", uri}});
        w.json["textures"].push_back({{"source", w.json["images"].size() - 1}});
        return w.json["textures"].size() - 1;
    }
    std::size_t png(const std::string& name, int width, int height, int channels, const std::vector<std::uint8_t>& codes) {
        savePng(folder / name, width, height, channels, codes);
        return texture(name);
    }
    Scene load() { return loadScene(w.write(folder)); }
};

void expectValues(const std::vector<float>& a, const std::vector<float>& b, float tolerance = 1e-6f) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "entry " << i;
}

TEST(GltfMaterials, DefaultsAreThoseOfGltf) {
    Fixture f;
    const Scene s = f.load();
    ASSERT_EQ(s.parameters.size(), 6u);
    expectValues(valuesOf(s, "wall.baseColor"), {1, 1, 1});
    expectValues(valuesOf(s, "wall.roughness"), {1});
    expectValues(valuesOf(s, "wall.metallic"), {1});
    expectValues(valuesOf(s, "wall.specular"), {1});
    expectValues(valuesOf(s, "wall.emission"), {0, 0, 0});
    expectValues(valuesOf(s, "wall.normal"), {0, 0, 1});
    EXPECT_EQ(s.materials[0].ior, 1.5f);
    EXPECT_FALSE(s.materials[0].hasNormalMap);
    EXPECT_TRUE(warned(s, "no light at all"));
    EXPECT_TRUE(warned(s, "no camera"));
    for (std::uint32_t k = 0; k < kCommonSlots; ++k) EXPECT_EQ(s.parameters[s.materials[0].parameters[k]].kind, SlotKind(k));
}

TEST(GltfMaterials, ConstantFactors) {
    Fixture f;
    f.material["pbrMetallicRoughness"] = {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"roughnessFactor", 0.5}, {"metallicFactor", 0.25}};
    f.material["emissiveFactor"] = {1, 0.5, 0};
    f.material["extensions"] = {{"KHR_materials_emissive_strength", {{"emissiveStrength", 8}}},
                                {"KHR_materials_specular", {{"specularFactor", 0.75}, {"specularColorFactor", {1, 0.5, 2}}}},
                                {"KHR_materials_ior", {{"ior", 1.33}}}};
    const Scene s = f.load();
    expectValues(valuesOf(s, "wall.baseColor"), {0.1f, 0.2f, 0.3f});
    expectValues(valuesOf(s, "wall.roughness"), {0.5f});
    expectValues(valuesOf(s, "wall.metallic"), {0.25f});
    expectValues(valuesOf(s, "wall.emission"), {8, 4, 0});
    expectValues(valuesOf(s, "wall.specular"), {0.75f});
    EXPECT_EQ(s.materials[0].specularColor, glm::vec3(1, 0.5f, 2));
    EXPECT_FLOAT_EQ(s.materials[0].ior, 1.33f);
    EXPECT_FALSE(warned(s, "no light"));
    EXPECT_FALSE(warned(s, "not rendered"));
}

// (1, -0.6, -1), whose z is taken for 0, and (0, 0, 1).
TEST(GltfMaterials, ClearCoatsHaveNormalsOfTheirOwn) {
    Fixture f;
    const std::size_t t = f.png("coat.png", 2, 1, 3, {255, 51, 0, 127, 127, 255});
    primitive(f.w)["attributes"]["NORMAL"] = f.w.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    Json& coat = f.material["extensions"]["KHR_materials_clearcoat"];
    coat = {{"clearcoatFactor", 0.5}, {"clearcoatNormalTexture", {{"index", t}, {"scale", 0.5}}}};
    const Scene s = f.load();
    ASSERT_TRUE(hasClearcoatNormals(s.materials[0]));
    const DirectionTexture& own = s.directionTextures.at(s.materials[0].clearcoatNormals);
    ASSERT_EQ(own.directions.size(), 2u);
    EXPECT_LT(glm::distance(own.directions[0], glm::normalize(glm::vec2(1, -0.6f))), 1e-6f);
    EXPECT_LT(glm::length(own.directions[1]), 4e-3f);
    EXPECT_EQ(s.geometry.tangents.size(), 3u);

    f.material["normalTexture"] = {{"index", t}};
    EXPECT_TRUE(hasClearcoatNormals(f.load().materials[0])) << "another scale";
    coat["clearcoatNormalTexture"].erase("scale");
    EXPECT_FALSE(hasClearcoatNormals(f.load().materials[0])) << "those of the surface";
    coat["clearcoatNormalTexture"]["texCoord"] = 1;
    EXPECT_TRUE(hasClearcoatNormals(f.load().materials[0])) << "at another place";

    // The extension: without a texture of its own the coat has no normal map.
    coat.erase("clearcoatNormalTexture");
    const Scene smooth = f.load();
    ASSERT_TRUE(hasClearcoatNormals(smooth.materials[0]));
    EXPECT_EQ(smooth.directionTextures.at(smooth.materials[0].clearcoatNormals).directions, std::vector<glm::vec2>{glm::vec2(0)});
    f.material.erase("normalTexture");
    EXPECT_FALSE(hasClearcoatNormals(f.load().materials[0]));

    for (const Json& bad : {Json{{"index", 7}}, Json{{"index", -1}}, Json{{"texCoord", 0}}, Json{{"index", t}, {"scale", 1e30}}, Json{{"index", t}, {"texCoord", "0"}}}) {
        coat["clearcoatNormalTexture"] = bad;
        EXPECT_THROW(f.load(), Error) << bad.dump();
    }
}

TEST(GltfMaterials, ClearCoat) {
    Fixture f;
    const std::size_t t = f.png("coat.png", 2, 1, 3, {255, 51, 0, 0, 102, 9});
    f.material["extensions"] = {{"KHR_materials_clearcoat", {{"clearcoatFactor", 0.5}, {"clearcoatTexture", {{"index", t}}},
                                                             {"clearcoatRoughnessFactor", 0.75}, {"clearcoatRoughnessTexture", {{"index", t}}}}}};
    f.w.json["extensionsRequired"] = {"KHR_materials_clearcoat"};
    const Scene s = f.load();
    ASSERT_EQ(s.parameters.size(), 8u);
    expectValues(valuesOf(s, "wall.clearcoat"), {0.5f, 0});
    expectValues(valuesOf(s, "wall.clearcoatRoughness"), {0.75f * 0.2f, 0.75f * 0.4f});
    EXPECT_FALSE(warned(s, "not rendered"));
    EXPECT_FALSE(hasClearcoatNormals(s.materials[0]));
    f.material["extensions"]["KHR_materials_clearcoat"] = Json::object();
    primitive(f.w)["attributes"]["NORMAL"] = f.w.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    f.material["emissiveFactor"] = {1, 1, 1};
    const Scene plain = f.load();
    expectValues(valuesOf(plain, "wall.clearcoat"), {0});
    expectValues(valuesOf(plain, "wall.clearcoatRoughness"), {0});
    EXPECT_TRUE(warned(plain, "as if there were none"));

    f.material["extensions"]["KHR_materials_clearcoat"] = {{"clearcoatFactor", 2}};
    EXPECT_THROW(f.load(), Error);

    f.material["extensions"] = {{"KHR_materials_clearcoat", Json::object()}, {"KHR_materials_transmission", {{"transmissionFactor", 1}}}};
    f.material["pbrMetallicRoughness"] = {{"metallicFactor", 0}};
    const Scene glass = f.load();
    EXPECT_EQ(glass.parameters.size(), 6u);
    EXPECT_TRUE(warned(glass, "which is glass"));
}

TEST(GltfMaterials, Sheen) {
    Fixture f;
    const std::size_t t = f.png("velvet.png", 2, 1, 4, {255, 0, 51, 51, 188, 0, 0, 102});
    Json& sheen = f.material["extensions"]["KHR_materials_sheen"];
    sheen = {{"sheenColorFactor", {0.5, 1, 1}}, {"sheenColorTexture", {{"index", t}}}, {"sheenRoughnessFactor", 0.75}, {"sheenRoughnessTexture", {{"index", t}}}};
    f.w.json["extensionsRequired"] = {"KHR_materials_sheen"};
    const Scene s = f.load();
    ASSERT_EQ(s.parameters.size(), 8u);
    const auto decoded = [](double code) { return float(std::pow((code / 255 + 0.055) / 1.055, 2.4)); };
    expectValues(valuesOf(s, "wall.sheenColor"), {0.5f, 0, decoded(51), 0.5f * decoded(188), 0, 0});
    expectValues(valuesOf(s, "wall.sheenRoughness"), {0.75f * 0.2f, 0.75f * 0.4f}); // alpha is linear
    EXPECT_FALSE(warned(s, "not rendered"));

    sheen = Json::object();
    const Scene plain = f.load();
    expectValues(valuesOf(plain, "wall.sheenColor"), {0, 0, 0});
    expectValues(valuesOf(plain, "wall.sheenRoughness"), {0});
    sheen = {{"sheenColorFactor", {2, 0.5, -1}}};
    const Scene outside = f.load();
    expectValues(valuesOf(outside, "wall.sheenColor"), {1, 0.5f, 0});
    EXPECT_TRUE(warned(outside, "outside the range"));
    for (const Json& bad : {Json{{"sheenRoughnessFactor", 2}}, Json{{"sheenColorFactor", 1}}, Json{{"sheenColorFactor", {1, 1}}}, Json{{"sheenColorTexture", {{"index", 99}}}}}) {
        sheen = bad;
        EXPECT_THROW(f.load(), Error) << bad;
    }

    f.material["extensions"] = {{"KHR_materials_sheen", Json::object()}, {"KHR_materials_transmission", {{"transmissionFactor", 1}}}};
    f.material["pbrMetallicRoughness"] = {{"metallicFactor", 0}};
    EXPECT_TRUE(warned(f.load(), "which is glass"));
    f.material["extensions"]["KHR_materials_transmission"] = {{"transmissionFactor", 0.5}};
    const Scene half = f.load();
    EXPECT_TRUE(warned(half, "its sheen covers what scatters light alone"));
    EXPECT_TRUE(hasSheen(half.materials[0]));
    ASSERT_NE(half.materials[0].blendWith, kNoMaterial);
    EXPECT_FALSE(hasSheen(half.materials[half.materials[0].blendWith]));
}

TEST(GltfMaterials, Anisotropy) {
    Fixture f;
    // Along the tangent, along the bitangent; the strength is blue.
    const std::size_t t = f.png("brushed.png", 2, 1, 3, {255, 128, 51, 128, 255, 255});
    Json& anisotropy = f.material["extensions"]["KHR_materials_anisotropy"];
    anisotropy = {{"anisotropyStrength", 0.5}, {"anisotropyTexture", {{"index", t}}}};
    f.w.json["extensionsRequired"] = {"KHR_materials_anisotropy"};
    const auto expectDirections = [](const Scene& s, const std::vector<glm::vec2>& expected) {
        ASSERT_NE(s.materials[0].anisotropyDirection, ~0u);
        const DirectionTexture& d = s.directionTextures.at(s.materials[0].anisotropyDirection);
        ASSERT_EQ(d.directions.size(), expected.size());
        for (std::size_t i = 0; i < expected.size(); ++i)
            EXPECT_LT(glm::distance(glm::normalize(d.directions[i]), expected[i]), 0.005) << i;
    };
    const Scene s = f.load();
    ASSERT_EQ(s.parameters.size(), 7u);
    expectValues(valuesOf(s, "wall.anisotropy"), {0.5f * 0.2f, 0.5f});
    expectDirections(s, {{1, 0}, {0, 1}});
    EXPECT_FALSE(warned(s, "not rendered"));
    EXPECT_FALSE(warned(s, "neither tangents nor texture coordinates"));
    Json& attributes = f.w.json["meshes"][0]["primitives"][0]["attributes"];
    const Json coordinates = attributes["TEXCOORD_0"];
    attributes.erase("TEXCOORD_0");
    EXPECT_TRUE(warned(f.load(), "neither tangents nor texture coordinates"));
    attributes["TEXCOORD_0"] = coordinates;

    anisotropy["anisotropyRotation"] = 0.5;
    const float c = std::cos(0.5f), r = std::sin(0.5f);
    expectDirections(f.load(), {{c, r}, {-r, c}});
    anisotropy = {{"anisotropyStrength", 1}, {"anisotropyRotation", 0.5}};
    const Scene turned = f.load();
    expectValues(valuesOf(turned, "wall.anisotropy"), {1});
    expectDirections(turned, {{c, r}});
    anisotropy = Json::object();
    const Scene none = f.load();
    expectValues(valuesOf(none, "wall.anisotropy"), {0});
    EXPECT_EQ(none.materials[0].anisotropyDirection, ~0u);

    for (const Json& bad : {Json{{"anisotropyStrength", 2}}, Json{{"anisotropyStrength", -0.5}}, Json{{"anisotropyRotation", "quarter"}}, Json{{"anisotropyTexture", {{"index", 99}}}}}) {
        anisotropy = bad;
        EXPECT_THROW(f.load(), Error) << bad;
    }

    // Rough glass has it, a pane does not.
    anisotropy = {{"anisotropyStrength", 0.5}};
    f.material["extensions"]["KHR_materials_transmission"] = {{"transmissionFactor", 1}};
    f.material["pbrMetallicRoughness"] = {{"metallicFactor", 0}, {"roughnessFactor", 0.5}};
    EXPECT_TRUE(warned(f.load(), "which is glass"));
    f.material["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}};
    const Scene glass = f.load();
    expectValues(valuesOf(glass, "wall.anisotropy"), {0.5f});
    EXPECT_TRUE(hasAnisotropy(glass.materials[0]));
    EXPECT_FALSE(warned(glass, "which is glass"));
}

TEST(GltfMaterials, BaseColorTextureIsDecodedAndFolded) {
    Fixture f;
    const std::size_t t = f.png("c.png", 2, 1, 3, {188, 0, 255, 10, 20, 30});
    f.material["pbrMetallicRoughness"] = {{"baseColorTexture", {{"index", t}}}, {"baseColorFactor", {0.5, 1, 0.25, 1}}};
    const Scene s = f.load();
    const Parameter& p = find(s, "wall.baseColor");
    EXPECT_TRUE(p.textured);
    EXPECT_TRUE(p.values.empty()) << "8-bit textures stay packed until somebody changes them";
    EXPECT_EQ(p.bytes.size(), 6u);
    EXPECT_EQ(p.width, 2u);
    const auto lin = [](int code) { return srgbDecode(float(code) / 255); };
    expectValues(valuesOf(s, "wall.baseColor"), {0.5f * lin(188), 0, 0.25f, 0.5f * lin(10), lin(20), 0.25f * lin(30)});
}

TEST(GltfMaterials, LinearAndFloatTexturesAreNotDecoded) {
    Fixture f;
    const std::size_t t = f.png("c.png", 1, 1, 3, {51, 102, 204});
    f.w.json["images"][0]["extras"] = {{"colorSpace", "linear"}};
    f.material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", t}};
    saveExr(f.folder / "e.exr", 1, 1, "RGB", {3, 0.5f, 0});
    f.material["emissiveTexture"] = {{"index", f.texture("e.exr")}};
    f.material["emissiveFactor"] = {1, 1, 1};
    const Scene s = f.load();
    expectValues(valuesOf(s, "wall.baseColor"), {0.2f, 0.4f, 0.8f});
    expectValues(valuesOf(s, "wall.emission"), {3, 0.5f, 0});
}

// It is looked up at zeros, and not by the first set, whatever other meshes have.
TEST(GltfMaterials, TexturesByASetThatMeshesLackAreNamed) {
    Fixture f;
    const std::size_t t = f.png("c.png", 2, 1, 3, {51, 102, 204, 255, 0, 0});
    f.material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", t}, {"texCoord", 1}};
    const Scene s = f.load();
    EXPECT_TRUE(warned(s, "wall.baseColor: a mesh with this texture has no second set of texture coordinates"));
    EXPECT_TRUE(analyse(s, {}).texcoord1);
    f.material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", t}};
    EXPECT_FALSE(warned(f.load(), "texture coordinates"));
}

TEST(GltfMaterials, RoughnessIsGreenAndMetallicIsBlue) {
    Fixture f;
    const std::size_t t = f.png("mr.png", 1, 1, 3, {255, 102, 51});
    f.material["pbrMetallicRoughness"] = {{"metallicRoughnessTexture", {{"index", t}}}, {"roughnessFactor", 0.5}};
    const Scene s = f.load();
    expectValues(valuesOf(s, "wall.roughness"), {0.2f});
    expectValues(valuesOf(s, "wall.metallic"), {0.2f});
    EXPECT_EQ(find(s, "wall.roughness").channels, 1u);
}

TEST(GltfMaterials, SpecularTextureIsAlpha) {
    Fixture f;
    const std::size_t t = f.png("s.png", 1, 1, 4, {1, 2, 3, 102});
    f.material["extensions"]["KHR_materials_specular"] = {
        {"specularTexture", {{"index", t}}}, {"specularFactor", 0.5}, {"specularColorTexture", {{"index", t}}}};
    const Scene s = f.load();
    expectValues(valuesOf(s, "wall.specular"), {0.2f});
    EXPECT_TRUE(warned(s, "specularColorTexture of wall"));
}

TEST(GltfMaterials, NormalTextureFoldsItsScaleIntoXAndY) {
    Fixture f;
    const std::size_t t = f.png("n.png", 1, 1, 3, {255, 51, 204});
    f.material["normalTexture"] = {{"index", t}, {"scale", 0.5}};
    primitive(f.w)["attributes"]["NORMAL"] = f.w.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    primitive(f.w)["attributes"]["TANGENT"] = f.w.floats({2, 0, 0, 1, 1, 0, 0, -1, 0, 0, 0, 1}, 4);
    f.w.json["nodes"][0]["scale"] = {-1, 1, 1};
    const Scene s = f.load();
    EXPECT_TRUE(s.materials[0].hasNormalMap);
    expectValues(valuesOf(s, "wall.normal"), {0.5f, 0.5f * (2 * 0.2f - 1), 2 * 0.8f - 1});
    ASSERT_EQ(s.geometry.tangents.size(), 3u);
    EXPECT_EQ(s.geometry.tangents[0], glm::vec4(-1, 0, 0, -1)) << "a mirror flips the handedness";
    EXPECT_EQ(s.geometry.tangents[1].w, 1);
    EXPECT_EQ(s.geometry.tangents[2], glm::vec4(0));
}

TEST(GltfMaterials, SamplerAndTextureTransform) {
    Fixture f;
    const std::size_t t = f.png("c.png", 1, 1, 3, {0, 0, 0});
    f.w.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
    f.w.json["textures"][0]["sampler"] = 0;
    // The specification's example: the lower left quarter of the image, turned clockwise by 90 degrees.
    f.material["pbrMetallicRoughness"]["baseColorTexture"] = {
        {"index", t},
        {"texCoord", 1},
        {"extensions", {{"KHR_texture_transform", {{"offset", {0, 1}}, {"rotation", 1.57079632679}, {"scale", {0.5, 0.5}}}}}}};
    const Scene s = f.load();
    const Parameter& p = find(s, "wall.baseColor");
    EXPECT_EQ(p.wrapU, Wrap::Clamp);
    EXPECT_EQ(p.wrapV, Wrap::Mirror);
    EXPECT_TRUE(p.nearest);
    EXPECT_EQ(p.texcoord, 1u);
    const auto map = [&](float u, float v) { return p.uvTransform * glm::vec3(u, v, 1); };
    const std::pair<glm::vec2, glm::vec2> corners[] = {
        {{0, 0}, {0, 1}}, {{1, 0}, {0, 0.5f}}, {{0, 1}, {0.5f, 1}}, {{1, 1}, {0.5f, 0.5f}}};
    for (const auto& [from, to] : corners) EXPECT_NEAR(glm::length(map(from.x, from.y) - to), 0, 1e-6f) << from.x << " " << from.y;
}

TEST(GltfMaterials, MaskKeepsTheAlphaOfTheTexture) {
    Fixture f;
    const std::size_t t = f.png("c.png", 2, 1, 4, {9, 9, 9, 0, 9, 9, 9, 200});
    f.material["pbrMetallicRoughness"] = {{"baseColorTexture", {{"index", t}}}, {"baseColorFactor", {1, 1, 1, 0.5}}};
    f.material["alphaMode"] = "MASK";
    f.material["alphaCutoff"] = 0.25;
    const Scene s = f.load();
    const Material& m = s.materials[0];
    EXPECT_TRUE(m.alphaMask);
    EXPECT_FLOAT_EQ(m.alphaCutoff, 0.25f);
    EXPECT_FLOAT_EQ(m.alphaFactor, 0.5f);
    ASSERT_EQ(m.alphaTexture, 0u);
    EXPECT_EQ(s.alphaTextures[0].alpha, (std::vector<std::uint8_t>{0, 200}));
    f.material["alphaMode"] = "BLEND";
    const Scene blended = f.load();
    EXPECT_TRUE(blended.materials[0].alphaMask && blended.materials[0].coverage);
    EXPECT_FLOAT_EQ(blended.materials[0].alphaFactor, 0.5f);
    EXPECT_EQ(blended.alphaTextures[0].alpha, (std::vector<std::uint8_t>{0, 200}));
    EXPECT_FALSE(m.coverage);
}

TEST(GltfMaterials, TransmissionMakesPanesAndWithAVolumeBoundaries) {
    Fixture f;
    f.material["pbrMetallicRoughness"] = {{"baseColorFactor", {0.9, 0.8, 0.7, 1}}, {"roughnessFactor", 0}, {"metallicFactor", 0}};
    f.material["extensions"] = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                                {"KHR_materials_ior", {{"ior", 1.33}}},
                                {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {1, 0.5, 4}}}}};
    const Scene pane = f.load();
    EXPECT_EQ(pane.materials[0].model, SurfaceModel::ThinDielectric);
    EXPECT_TRUE(isSmooth(pane.materials[0]));
    EXPECT_FLOAT_EQ(pane.materials[0].ior, 1.33f);
    expectValues(valuesOf(pane, "wall.baseColor"), {0.9f, 0.8f, 0.7f});
    expectValues(valuesOf(pane, "wall.specular"), {0.5f, 0.25f, 1}); // RGB, clamped
    EXPECT_FALSE(warned(pane, "not rendered"));
    f.material["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 0.1}};
    const Scene solid = f.load();
    EXPECT_EQ(solid.materials[0].model, SurfaceModel::Dielectric);
    EXPECT_TRUE(isSmooth(solid.materials[0]));
    f.material["pbrMetallicRoughness"]["roughnessFactor"] = 0.5;
    const Scene rough = f.load();
    EXPECT_FALSE(isSmooth(rough.materials[0]));
    EXPECT_FALSE(rough.materials[0].roughnessIsAlpha);
    EXPECT_EQ(rough.materials[0].microfacets, Microfacets::Ggx);
    f.material["extensions"]["KHR_materials_volume"]["attenuationDistance"] = 2;
    EXPECT_EQ(f.load().materials[0].absorption, glm::vec3(0)) << "white";
    f.material["extensions"]["KHR_materials_volume"]["attenuationColor"] = {1, 0.25, 0};
    const Scene coloured = f.load();
    EXPECT_EQ(coloured.materials[0].absorption.x, 0);
    EXPECT_NEAR(coloured.materials[0].absorption.y, std::log(2.0), 1e-6);
    EXPECT_GT(coloured.materials[0].absorption.z, 5) << "black is as dark as 1e-6";
    EXPECT_FALSE(warned(coloured, "not rendered"));
    f.material["alphaMode"] = "BLEND";
    const Scene covered = f.load();
    EXPECT_EQ(covered.materials[0].absorption, glm::vec3(0));
    EXPECT_TRUE(warned(covered, "not rendered: attenuation in the volume of wall, which alpha"));
}

TEST(GltfMaterials, TransmissionInPartBlendsWithGlass) {
    Fixture f;
    f.material["pbrMetallicRoughness"] = {{"roughnessFactor", 0.4}};
    f.material["extensions"] = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}};
    const Scene metal = f.load(); // metallicFactor is 1
    EXPECT_EQ(metal.materials[0].model, SurfaceModel::MetallicRoughness);
    EXPECT_EQ(metal.materials[0].blendWith, kNoMaterial);

    f.material["pbrMetallicRoughness"]["metallicFactor"] = 0;
    f.material["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = 0.25;
    f.material["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}, {"attenuationDistance", 2}, {"attenuationColor", {0.5, 0.5, 0.5}}};
    const Scene part = f.load();
    const Material& first = part.materials[0];
    EXPECT_EQ(first.model, SurfaceModel::MetallicRoughness);
    ASSERT_NE(first.blendWith, kNoMaterial);
    const Material& glass = part.materials.at(first.blendWith);
    EXPECT_EQ(glass.model, SurfaceModel::Dielectric);
    EXPECT_FALSE(isSmooth(glass));
    EXPECT_FALSE(glass.roughnessIsAlpha);
    EXPECT_GT(glass.absorption.x, 0);
    EXPECT_EQ(glass.parameters, first.parameters) << "they share all slots";
    expectValues(valuesOf(part, "wall.transmission"), {0.25f});
    EXPECT_FALSE(warned(part, "lets light through"));
    f.material["extensions"].erase("KHR_materials_volume");
    const Scene pane = f.load();
    EXPECT_EQ(pane.materials.at(pane.materials[0].blendWith).model, SurfaceModel::ThinDielectric);
    f.material["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = 2;
    EXPECT_THROW(f.load(), Error);
}

TEST(GltfMaterials, TransmissionTexturesAndMetalMakeTheWeight) {
    Fixture f;
    const std::size_t t = f.png("clear.png", 2, 1, 3, {255, 9, 9, 51, 9, 9}), m = f.png("metal.png", 2, 1, 3, {0, 0, 0, 0, 0, 255});
    f.material["pbrMetallicRoughness"] = {{"roughnessFactor", 0}, {"metallicFactor", 0}};
    f.material["extensions"] = {{"KHR_materials_transmission", {{"transmissionFactor", 0.5}, {"transmissionTexture", {{"index", t}}}}}};
    expectValues(valuesOf(f.load(), "wall.transmission"), {0.5f, 0.1f}); // red
    f.material["pbrMetallicRoughness"] = {{"metallicRoughnessTexture", {{"index", m}}}};
    expectValues(valuesOf(f.load(), "wall.transmission"), {0.5f, 0});
    f.material["extensions"]["KHR_materials_transmission"].erase("transmissionTexture");
    const Scene s = f.load();
    expectValues(valuesOf(s, "wall.transmission"), {0.5f, 0});
    EXPECT_FALSE(warned(s, "metal in part"));
    f.material["pbrMetallicRoughness"] = {{"metallicFactor", 0.5}};
    const Scene mixed = f.load();
    expectValues(valuesOf(mixed, "wall.transmission"), {0.25f});
    EXPECT_TRUE(warned(mixed, "metal in part"));
}

TEST(GltfMaterials, UnsupportedExtensionsAreNamedOnce) {
    Fixture f;
    f.w.json["extensionsUsed"] = {"KHR_materials_dispersion", "KHR_materials_diffuse_transmission"};
    f.material["extensions"] = {{"KHR_materials_iridescence", Json::object()}};
    EXPECT_TRUE(warned(f.load(), "not rendered: KHR_materials_diffuse_transmission, KHR_materials_dispersion, KHR_materials_iridescence"));
}

TEST(GltfMaterials, UnlitIsRefused) {
    Fixture f;
    f.material["extensions"] = {{"KHR_materials_unlit", Json::object()}};
    try {
        f.load();
        FAIL();
    } catch (const Error& e) {
        EXPECT_EQ(e.kind, ErrorKind::Input);
        EXPECT_NE(std::string(e.what()).find("materials[0].extensions.KHR_materials_unlit"), std::string::npos) << e.what();
        EXPECT_NE(e.cause.find("scatters no light"), std::string::npos) << e.cause;
    }
}

TEST(GltfMaterials, NamesAreUniqueAndPrintable) {
    Fixture f;
    f.w.json["materials"] = {{{"name", "a"}}, Json::object(), {{"name", "a"}}, {{"name", "x\u001b[2J"}}};
    primitive(f.w).erase("material");
    const Scene s = f.load();
    std::vector<std::string> names;
    for (const Material& m : s.materials) names.push_back(m.name);
    EXPECT_EQ(names, (std::vector<std::string>{"a", "material1", "a#2", "x_[2J", "material4"}));
    EXPECT_EQ(s.geometry.triangles[0].material, 4u);
}

TEST(GltfMaterials, ImagesInTheBinaryChunkAndInDataUris) {
    Fixture f;
    savePng(f.folder / "c.png", 1, 1, 3, {51, 102, 204});
    const std::string file = readText(f.folder / "c.png");
    f.w.json["images"] = {{{"bufferView", f.w.view(std::vector<std::uint8_t>(file.begin(), file.end()))}, {"mimeType", "image/png"}}};
    f.w.json["textures"] = {{{"source", 0}}};
    f.material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {{"index", 0}};
    writeText(f.folder / "s.glb", f.w.glb());
    expectValues(valuesOf(loadScene(f.folder / "s.glb"), "wall.roughness"), {0.4f});
    // A grey pixel of code 128, as base64 of a PNG written elsewhere (Python's zlib).
    f.w.json["images"] = {{{"uri", "data:image/png;base64,"
                                     "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6"
                                     "fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg=="}}};
    expectValues(valuesOf(f.load(), "wall.roughness"), {128 / 255.0f});
}

} // namespace
} // namespace cmpg::test

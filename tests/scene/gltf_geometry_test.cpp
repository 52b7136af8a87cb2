// Geometry of glTF scenes: accessors, primitive modes, node transforms.
#include "gltf_writer.h"

#include <cmath>

namespace cmpg::test {
namespace {

Scene load(GltfWriter& w) {
    const TempFolder folder;
    return loadScene(w.write(folder));
}

glm::vec3 corner(const Scene& s, std::size_t triangle, std::size_t i) {
    return s.geometry.positions[s.geometry.triangles[triangle].vertices[i]];
}
glm::vec3 faceNormal(const Scene& s, std::size_t t) {
    return glm::normalize(glm::cross(corner(s, t, 1) - corner(s, t, 0), corner(s, t, 2) - corner(s, t, 0)));
}

TEST(GltfGeometry, ReadsOneTriangle) {
    GltfWriter w = oneTriangle();
    const Scene s = load(w);
    ASSERT_EQ(s.geometry.triangles.size(), 1u);
    expectVec(corner(s, 0, 1), {1, 0, 0});
    expectVec(faceNormal(s, 0), {0, 0, 1});
    EXPECT_TRUE(s.geometry.normals.empty());
    EXPECT_TRUE(s.geometry.colors.empty());
    EXPECT_TRUE(s.geometry.uv1.empty());
    ASSERT_EQ(s.geometry.uv0.size(), 3u);
    EXPECT_EQ(s.geometry.uv0[1], glm::vec2(1, 0));
    EXPECT_EQ(s.maxDepth, 8u);
}

TEST(GltfGeometry, BinaryContainerReadsTheSame) {
    GltfWriter w = oneTriangle();
    const TempFolder folder;
    writeText(folder / "scene.glb", w.glb());
    const Scene s = loadScene(folder / "scene.glb");
    ASSERT_EQ(s.geometry.triangles.size(), 1u);
    expectVec(corner(s, 0, 2), {0, 1, 0});
}

TEST(GltfGeometry, NodesComposeFromRootToLeaf) {
    GltfWriter w = oneTriangle();
    const float h = std::sqrt(0.5f); // a quarter turn about z takes x to y
    w.json["nodes"] = {{{"translation", {10, 0, 0}}, {"children", {1}}}, {{"mesh", 0}, {"rotation", {0, 0, h, h}}, {"scale", {2, 2, 2}}}};
    expectVec(corner(load(w), 0, 1), {10, 2, 0}, 1e-5f);
}

TEST(GltfGeometry, MatrixIsColumnMajor) {
    GltfWriter w = oneTriangle();
    w.json["nodes"][0]["matrix"] = {2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1};
    const Scene s = load(w);
    expectVec(corner(s, 0, 0), {5, 6, 7});
    expectVec(corner(s, 0, 2), {5, 9, 7});
}

// Programs that invert matrices leave a last row of (0, 0, 0, 1) but for rounding.
TEST(GltfGeometry, MatrixMayBeRounded) {
    GltfWriter w = oneTriangle();
    w.json["nodes"][0]["matrix"] = {2, 0, 0, -1e-17, 0, 3, 0, 1e-9, 0, 0, 1, 0, 5, 6, 7, 0.9999999999999998};
    expectVec(corner(load(w), 0, 2), {5, 9, 7});
}

TEST(GltfGeometry, MirroredNodeKeepsTheFrontInFront) {
    GltfWriter w = oneTriangle();
    const float h = std::sqrt(0.5f);
    primitive(w)["attributes"]["NORMAL"] = w.floats({h, 0, h, h, 0, h, h, 0, h}, 3);
    w.json["nodes"][0]["scale"] = {-1, 1, 1};
    const Scene s = load(w);
    expectVec(faceNormal(s, 0), {0, 0, 1}); // a mirror in x does not turn a face that looks along z
    expectVec(s.geometry.normals[0], {-h, 0, h});
}

TEST(GltfGeometry, NormalsStayPerpendicularUnderUnevenScale) {
    GltfWriter w = oneTriangle();
    const float h = std::sqrt(0.5f);
    primitive(w)["attributes"]["NORMAL"] = w.floats({h, h, 0, h, h, 0, h, h, 0}, 3);
    w.json["nodes"][0]["scale"] = {2, 1, 1};
    // Inverse transpose: (1/2, 1, 0) normalised.
    expectVec(load(w).geometry.normals[0], {1 / std::sqrt(5.0f), 2 / std::sqrt(5.0f), 0});
}

TEST(GltfGeometry, StripsAndFansTurnTheSameWay) {
    for (const int mode : {5, 6}) {
        GltfWriter w = oneTriangle();
        const std::vector<float> strip{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, fan{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, -1, 1, 0};
        primitive(w)["attributes"] = {{"POSITION", w.floats(mode == 5 ? strip : fan, 3)}};
        primitive(w)["mode"] = mode;
        const Scene s = load(w);
        ASSERT_EQ(s.geometry.triangles.size(), 3u) << "mode " << mode;
        for (std::size_t t = 0; t < 3; ++t) expectVec(faceNormal(s, t), {0, 0, 1});
    }
}

TEST(GltfGeometry, IndicesOfEveryType) {
    for (const int type : {5121, 5123, 5125}) {
        GltfWriter w = oneTriangle();
        primitive(w)["indices"] = type == 5121   ? w.accessor(std::vector<std::uint8_t>{0, 2, 1}, 1, type)
                                  : type == 5123 ? w.accessor(std::vector<std::uint16_t>{0, 2, 1}, 1, type)
                                                 : w.accessor(std::vector<std::uint32_t>{0, 2, 1}, 1, type);
        expectVec(faceNormal(load(w), 0), {0, 0, -1});
    }
}

TEST(GltfGeometry, QuantisedPositions) {
    GltfWriter w = oneTriangle();
    w.json["extensionsRequired"] = {"KHR_mesh_quantization"};
    // int16, padded to 8 bytes an element; -32768 and -32767 both mean -1.
    const std::vector<std::int16_t> corners{-32768, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0};
    primitive(w)["attributes"]["POSITION"] = w.accessor(corners, 4, 5122, true);
    Json& accessor = w.json["accessors"].back();
    accessor["type"] = "VEC3";
    w.json["bufferViews"].back()["byteStride"] = 8;
    Scene s = load(w);
    expectVec(corner(s, 0, 0), {-1, 0, 0});
    expectVec(corner(s, 0, 1), {1, 0, 0});
    accessor["normalized"] = false;
    s = load(w);
    expectVec(corner(s, 0, 1), {32767, 0, 0});
}

TEST(GltfGeometry, SparseAccessorsWithAndWithoutBase) {
    for (const bool base : {true, false}) {
        GltfWriter w = oneTriangle();
        const std::size_t where = w.view(std::vector<std::uint8_t>{1, 2}), what = w.view(std::vector<float>{5, 0, 0, 0, 7, 0});
        Json& accessor = w.json["accessors"][0];
        if (!base) accessor.erase("bufferView");
        accessor["sparse"] = {{"count", 2},
                              {"indices", {{"bufferView", where}, {"componentType", 5121}}},
                              {"values", {{"bufferView", what}}}};
        const Scene s = load(w);
        expectVec(corner(s, 0, 0), {0, 0, 0});
        expectVec(corner(s, 0, 1), {5, 0, 0});
        expectVec(corner(s, 0, 2), {0, 7, 0});
    }
}

TEST(GltfGeometry, ColorsAndSecondTexcoords) {
    GltfWriter w = oneTriangle();
    primitive(w)["attributes"]["COLOR_0"] = w.accessor(std::vector<std::uint8_t>{255, 0, 51, 102, 0, 0, 0, 0, 0, 0, 0, 0}, 4, 5121, true);
    primitive(w)["attributes"]["TEXCOORD_1"] = w.accessor(std::vector<std::uint16_t>{65535, 0, 0, 0, 0, 0}, 2, 5123, true);
    // A second primitive without either gets the neutral values.
    w.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"material", 0}});
    const Scene s = load(w);
    ASSERT_EQ(s.geometry.colors.size(), 6u);
    EXPECT_FLOAT_EQ(s.geometry.colors[0].b, 0.2f);
    EXPECT_FLOAT_EQ(s.geometry.colors[0].a, 0.4f);
    EXPECT_EQ(s.geometry.colors[3], glm::vec4(1));
    EXPECT_FLOAT_EQ(s.geometry.uv1[0].x, 1.0f);
    EXPECT_EQ(s.geometry.uv1[3], glm::vec2(0));
}

TEST(GltfGeometry, TangentsOnlyWhereANormalMapNeedsThem) {
    GltfWriter w = oneTriangle();
    primitive(w)["attributes"]["NORMAL"] = w.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    primitive(w)["attributes"]["TANGENT"] = w.floats({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, 4);
    EXPECT_TRUE(load(w).geometry.tangents.empty());
}

TEST(GltfGeometry, DegenerateTrianglesAndUnusedVerticesAreCounted) {
    GltfWriter w = oneTriangle();
    primitive(w)["attributes"]["POSITION"] = w.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 9, 9, 9}, 3);
    primitive(w)["attributes"].erase("TEXCOORD_0");
    primitive(w)["indices"] = w.indices({0, 1, 2, 0, 1, 1, 0, 1, 3});
    const Scene s = load(w);
    EXPECT_EQ(s.geometry.triangles.size(), 1u);
    EXPECT_EQ(s.geometry.positions.size(), 4u);
    EXPECT_EQ(s.skippedTriangles, 2u);
    EXPECT_TRUE(warned(s, "2 degenerate triangles")) << "and in words";
    EXPECT_TRUE(warned(s, "1 vertices no triangle uses"));
}

TEST(GltfGeometry, PointsAndLinesAreNamed) {
    GltfWriter w = oneTriangle();
    w.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
    w.json["animations"] = {Json::object()};
    const Scene s = load(w);
    EXPECT_EQ(s.geometry.triangles.size(), 1u);
    EXPECT_TRUE(warned(s, "not rendered: animations, points and lines"));
}

TEST(GltfGeometry, FarAwayScenesAreRecentredInDouble) {
    GltfWriter w = oneTriangle();
    // float32 steps at 4e7 are 4: the triangle would collapse if the translation were added in float.
    w.json["nodes"][0]["translation"] = {4e7, -4e7 + 0.25, 0};
    w.json["nodes"][0]["extensions"]["KHR_lights_punctual"] = {{"light", 0}};
    w.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
    w.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1.0}}}}};
    w.json["nodes"][0]["camera"] = 0;
    const Scene s = load(w);
    EXPECT_DOUBLE_EQ(s.center.x, 4e7 + 0.5);
    EXPECT_DOUBLE_EQ(s.center.y, -4e7 + 0.75);
    expectVec(corner(s, 0, 1), {0.5f, -0.5f, 0});
    expectVec(s.lights[0].position, {-0.5f, -0.5f, 0});
    expectVec(glm::vec3(s.cameras[0].toWorld[3]), {-0.5f, -0.5f, 0});
}

TEST(GltfGeometry, OrdinaryScenesStayWhereTheyAre) {
    GltfWriter w = oneTriangle();
    w.json["nodes"][0]["translation"] = {5, 0, 0};
    const Scene s = load(w);
    EXPECT_EQ(s.center, glm::dvec3(0));
    expectVec(corner(s, 0, 1), {6, 0, 0});
}

TEST(GltfGeometry, FilesWithoutScenesShowTheirRoots) {
    GltfWriter w = oneTriangle();
    w.json.erase("scene");
    w.json.erase("scenes");
    w.json["nodes"] = {{{"mesh", 0}}, {{"children", {0}}, {"translation", {0, 0, 3}}}};
    expectVec(corner(load(w), 0, 0), {0, 0, 3});
}

} // namespace
} // namespace cmpg::test

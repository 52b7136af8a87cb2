// Tangents of glTF scenes whose files have none.
#include "gltf_writer.h"
#include "test_images.h"

namespace cmpg::test {
namespace {

// Two squares side by side in the plane z = 0, x from -1 to 1, texture coordinates (|x|, 1 - y): the picture is mirrored at x = 0.
struct Mirrored {
    TempFolder folder;
    GltfWriter w = oneTriangle();
    Json &material = w.json["materials"][0], &attributes = primitive(w)["attributes"];

    Mirrored() {
        savePng(folder / "normal.png", 1, 1, 3, {128, 128, 255});
        w.json["images"] = {{{"uri", "normal.png"}}};
        w.json["textures"] = {{{"source", 0}}};
        material["normalTexture"] = {{"index", 0}};
        attributes["POSITION"] = w.floats({-1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 1, 0, 0, 1, 0, 1, 1, 0}, 3);
        attributes["NORMAL"] = w.floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
        attributes["TEXCOORD_0"] = w.floats({1, 1, 0, 1, 1, 1, 1, 0, 0, 0, 1, 0}, 2);
        primitive(w)["indices"] = w.indices({0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4});
    }
    Scene load() { return loadScene(w.write(folder)); }
};

// Along growing u, and the bitangent along decreasing v: up in the picture.
void expectAlongPicture(const Scene& s, std::size_t triangle, glm::vec3 tangent, glm::vec3 bitangent) {
    for (const std::uint32_t v : s.geometry.triangles[triangle].vertices) {
        const glm::vec4 t = s.geometry.tangents[v];
        expectVec(glm::vec3(t), tangent);
        expectVec(t.w * glm::cross(s.geometry.normals[v], glm::vec3(t)), bitangent);
    }
}

TEST(GltfTangents, FollowThePictureAndSplitWhatItMirrors) {
    Mirrored m;
    const Scene s = m.load();
    ASSERT_EQ(s.geometry.positions.size(), 8u) << "the two vertices between";
    ASSERT_EQ(s.geometry.tangents.size(), 8u);
    for (const std::size_t left : {0, 1}) expectAlongPicture(s, left, {-1, 0, 0}, {0, 1, 0});
    for (const std::size_t right : {2, 3}) expectAlongPicture(s, right, {1, 0, 0}, {0, 1, 0});
    // Nothing else moved.
    m.material.erase("normalTexture");
    const Scene plain = m.load();
    EXPECT_TRUE(plain.geometry.tangents.empty());
    EXPECT_EQ(plain.geometry.positions.size(), 6u);
    for (std::size_t t = 0; t < 4; ++t)
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_EQ(s.geometry.positions[s.geometry.triangles[t].vertices[k]], plain.geometry.positions[plain.geometry.triangles[t].vertices[k]]);
}

TEST(GltfTangents, TurnWithTheNode) {
    Mirrored m;
    m.w.json["nodes"][0]["scale"] = {-1, 2, 1};
    const Scene s = m.load();
    for (const std::size_t first : {0, 1}) expectAlongPicture(s, first, {1, 0, 0}, {0, 1, 0});
    for (const std::size_t second : {2, 3}) expectAlongPicture(s, second, {-1, 0, 0}, {0, 1, 0});
}

TEST(GltfTangents, VerticesStayWhereNothingIsSplit) {
    Mirrored m;
    primitive(m.w)["indices"] = m.w.indices({1, 2, 5, 1, 5, 4});
    const Scene s = m.load();
    EXPECT_EQ(s.geometry.positions.size(), 4u);
    m.material.erase("normalTexture");
    const Scene plain = m.load();
    EXPECT_EQ(s.geometry.positions, plain.geometry.positions);
    for (std::size_t t = 0; t < 2; ++t) EXPECT_EQ(s.geometry.triangles[t].vertices, plain.geometry.triangles[t].vertices);
}

// Not on a plane, so that tangents are means over triangles.
TEST(GltfTangents, OfStripsAndFilesThatBringThemAreTheSame) {
    Mirrored m;
    m.attributes["POSITION"] = m.w.floats({-1, 0, 0.5, 0, 0, 0, 1, 0, 0.3, -1, 1, 0.2, 0, 1, 0.1, 1, 1, -0.4}, 3);
    m.attributes["TEXCOORD_0"] = m.w.floats({0, 1, 0.5, 1.1, 1, 1, 0, 0, 0.4, 0, 1, 0}, 2);
    primitive(m.w)["indices"] = m.w.indices({0, 1, 3, 3, 1, 4, 4, 1, 5, 5, 1, 2});
    const Scene list = m.load();
    ASSERT_EQ(list.geometry.positions.size(), 6u);
    std::vector<float> tangents(6 * 4);
    for (std::size_t v = 0; v < 6; ++v) { // in the order in which triangles first use them
        const std::array<std::size_t, 6> inFile{0, 1, 3, 4, 5, 2};
        for (std::size_t k = 0; k < 4; ++k) tangents[inFile[v] * 4 + k] = list.geometry.tangents[v][int(k)];
    }
    EXPECT_GT(glm::distance(list.geometry.tangents[1], list.geometry.tangents[2]), 0.01f);
    m.attributes["TANGENT"] = m.w.floats(tangents, 4);
    const Scene given = m.load();
    ASSERT_EQ(given.geometry.tangents.size(), 6u);
    for (std::size_t v = 0; v < 6; ++v) {
        expectVec(glm::vec3(given.geometry.tangents[v]), glm::vec3(list.geometry.tangents[v]));
        EXPECT_EQ(given.geometry.tangents[v].w, list.geometry.tangents[v].w);
    }

    m.attributes.erase("TANGENT");
    primitive(m.w)["indices"] = m.w.indices({0, 1, 3, 4});
    primitive(m.w)["mode"] = 5;
    const Scene strip = m.load();
    primitive(m.w)["indices"] = m.w.indices({0, 1, 3, 1, 4, 3});
    primitive(m.w)["mode"] = 4;
    EXPECT_EQ(strip.geometry.tangents, m.load().geometry.tangents);
}

TEST(GltfTangents, FollowTheCoordinatesOfTheNormalMap) {
    Mirrored m;
    m.attributes["TEXCOORD_1"] = m.w.floats({0, 0, 0, 1, 0, 2, 1, 0, 1, 1, 1, 2}, 2); // u up, v to the right
    m.material["normalTexture"]["texCoord"] = 1;
    const Scene s = m.load();
    EXPECT_EQ(s.geometry.positions.size(), 6u);
    for (std::size_t t = 0; t < 4; ++t) expectAlongPicture(s, t, {0, 1, 0}, {-1, 0, 0});
    m.attributes.erase("TEXCOORD_1");
    EXPECT_TRUE(m.load().geometry.tangents.empty());
}

TEST(GltfTangents, AreMadeForAnisotropyAndOnlyWithNormals) {
    Mirrored m;
    m.material.erase("normalTexture");
    m.material["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", 0.5}};
    expectAlongPicture(m.load(), 3, {1, 0, 0}, {0, 1, 0});
    m.attributes.erase("NORMAL");
    EXPECT_TRUE(m.load().geometry.tangents.empty()) << "a flat triangle's own follow from its coordinates";
}

} // namespace
} // namespace cmpg::test

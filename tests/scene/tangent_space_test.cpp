// Tangents against the reference implementation of MikkTSpace (tests/reference/make_tangents.py), and on meshes made to be hard.
#include "scene/tangent_space.h"

#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <random>

namespace cmpg::test {
namespace {

using Json = nlohmann::json;

template <class V> std::vector<V> vectors(const Json& numbers) {
    std::vector<V> out(numbers.size() / std::size_t(V::length()));
    for (std::size_t i = 0; i < numbers.size(); ++i)
        out[i / std::size_t(V::length())][int(i) % V::length()] = numbers[i].get<float>();
    return out;
}

struct Reference {
    std::string name;
    TangentMesh mesh;
    std::vector<glm::vec4> tangents; // of corners
};

std::vector<Reference> references() {
    std::ifstream file(std::string(CMPG_SOURCE_DIR) + "/tests/reference/tangents.json");
    const Json all = Json::parse(file);
    std::vector<Reference> out;
    for (const Json& m : all.at("meshes"))
        out.push_back({m["name"], {vectors<glm::vec3>(m["positions"]), vectors<glm::vec3>(m["normals"]), vectors<glm::vec2>(m["uvs"]), m["corners"]}, vectors<glm::vec4>(m["tangents"])});
    return out;
}

// Of a corner without direction the reference says (1, 0, 0) and -1, or zero where directions cancel or are along the normal.
void expectTangents(const std::vector<glm::vec4>& tangents, const std::vector<glm::vec4>& expected, const std::string& name) {
    ASSERT_EQ(tangents.size(), expected.size()) << name;
    for (std::size_t c = 0; c < tangents.size(); ++c) {
        const glm::vec4 none = glm::vec3(expected[c]) == glm::vec3(0) ? expected[c] : glm::vec4(1, 0, 0, -1), t = tangents[c] == glm::vec4(0) ? none : tangents[c];
        EXPECT_LT(glm::distance(glm::vec3(t), glm::vec3(expected[c])), 1e-5f) << name << ", corner " << c;
        EXPECT_EQ(t.w, expected[c].w) << name << ", corner " << c;
    }
}

TEST(TangentSpace, IsThatOfTheReferenceImplementation) {
    const std::vector<Reference> all = references();
    ASSERT_GE(all.size(), 10u);
    std::size_t directed = 0, corners = 0;
    for (const Reference& r : all) {
        const std::vector<glm::vec4> tangents = mikkTangents(r.mesh);
        expectTangents(tangents, r.tangents, r.name);
        corners += tangents.size();
        directed += tangents.size() - std::size_t(std::count(tangents.begin(), tangents.end(), glm::vec4(0)));
    }
    EXPECT_GT(directed, corners * 8 / 10);
}

// What is equal is one vertex, so indices do not matter; zero has no sign.
TEST(TangentSpace, IndicesDoNotMatter) {
    for (const Reference& r : references()) {
        TangentMesh soup;
        for (const std::uint32_t v : r.mesh.corners) {
            soup.corners.push_back(std::uint32_t(soup.corners.size()));
            soup.positions.push_back(r.mesh.positions[v]);
            soup.normals.push_back(r.mesh.normals[v]);
            soup.uvs.push_back(r.mesh.uvs[v]);
            for (int k = 0; k < 3; ++k)
                if (soup.positions.back()[k] == 0 && soup.corners.size() % 2) soup.positions.back()[k] = -0.0f;
        }
        EXPECT_EQ(mikkTangents(soup), mikkTangents(r.mesh)) << r.name;
    }
}

TEST(TangentSpace, FollowsTexturesAlongUAndV) {
    TangentMesh quad{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, std::vector<glm::vec3>(4, {0, 0, 1}), {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {0, 1, 2, 0, 2, 3}};
    for (const glm::vec4& t : mikkTangents(quad)) EXPECT_EQ(t, glm::vec4(1, 0, 0, 1));
    for (glm::vec2& uv : quad.uvs) uv.y = -uv.y;
    for (const glm::vec4& t : mikkTangents(quad)) EXPECT_EQ(t, glm::vec4(1, 0, 0, -1));
    for (glm::vec2& uv : quad.uvs) uv = {uv.y, uv.x}; // u along -y, v along x
    for (const glm::vec4& t : mikkTangents(quad)) EXPECT_EQ(t, glm::vec4(0, -1, 0, 1));
}

// A disc of n triangles around a vertex, texture coordinates along the plane.
TangentMesh disc(std::uint32_t n) {
    TangentMesh mesh;
    const auto add = [&](glm::vec2 p) {
        mesh.positions.emplace_back(p, 0);
        mesh.normals.emplace_back(0, 0, 1);
        mesh.uvs.push_back(p);
    };
    add({0, 0});
    for (std::uint32_t i = 0; i < n; ++i) {
        const double a = 6.283185307179586 * i / n;
        add(glm::vec2(std::cos(a), std::sin(a)));
        mesh.corners.insert(mesh.corners.end(), {0, i + 1, (i + 1) % n + 1});
    }
    return mesh;
}

// Quadratic time would be minutes, and a recursion from triangle to triangle would overflow the stack.
TEST(TangentSpace, TakesAnyNumberOfTrianglesAroundAVertex) {
    for (const glm::vec4& t : mikkTangents(disc(300000)))
        ASSERT_LT(glm::distance(t, glm::vec4(1, 0, 0, 1)), 0.05f); // of slivers in single precision
}

// All run along one edge the same way, but for one that comes last.
TEST(TangentSpace, TakesAnyNumberOfTrianglesAtAnEdge) {
    constexpr std::uint32_t kCount = 300000;
    TangentMesh mesh{{{0, 0, 0}, {1, 0, 0}}, {}, {{0, 0}, {1, 0}}, {}};
    for (std::uint32_t i = 0; i < kCount; ++i) {
        const float y = 1 + float(i) / kCount;
        mesh.positions.emplace_back(0, y, 0);
        mesh.uvs.emplace_back(0, y);
        mesh.corners.insert(mesh.corners.end(), {0, 1, i + 2});
    }
    mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
    for (const glm::vec4& t : mikkTangents(mesh)) ASSERT_LT(glm::distance(t, glm::vec4(1, 0, 0, 1)), 1e-6f);
}

TEST(TangentSpace, GivesFiniteTangentsWhateverComes) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    const float huge = std::numeric_limits<float>::max(), none = std::numeric_limits<float>::quiet_NaN();
    for (const float scale : {1.0f, 1e20f, 3e38f, 1e-20f, 1e-38f, 1e-44f}) {
        TangentMesh mesh;
        const auto number = [&](float s) { return glm::clamp(normal(random) * s, -huge, huge); };
        for (int i = 0; i < 300; ++i) {
            mesh.positions.emplace_back(number(scale), number(1), number(scale));
            mesh.normals.push_back(i % 7 ? glm::normalize(glm::vec3(number(1), number(1), number(1))) : glm::vec3(0));
            mesh.uvs.emplace_back(number(scale), i % 31 ? number(1) : none);
        }
        for (int i = 0; i < 3000; ++i) mesh.corners.push_back(random() % 300);
        for (const glm::vec4& t : mikkTangents(mesh))
            for (int k = 0; k < 4; ++k) ASSERT_TRUE(std::isfinite(t[k])) << scale;
    }
    EXPECT_TRUE(mikkTangents({}).empty());
}

} // namespace
} // namespace cmpg::test

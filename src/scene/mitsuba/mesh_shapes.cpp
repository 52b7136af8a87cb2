// Mitsuba's analytic shapes as meshes.
#include "scene/mitsuba/mesh.h"

#include <cmath>
#include <numbers>

namespace cmpg {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kSegments = 64; // of a full turn

// The rectangles of a grid of (columns + 1) x (rows + 1) positions, row by row. `poles`: the first and last row are a point each.
void addGrid(Mesh& mesh, int columns, int rows, bool poles) {
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            const auto a = std::uint32_t(r * (columns + 1) + c), b = a + 1, below = a + std::uint32_t(columns) + 1;
            if (!poles || r > 0)
                mesh.triangles.emplace_back(a, below, b);
            if (!poles || r + 1 < rows)
                mesh.triangles.emplace_back(b, below, below + 1);
        }
}

double areaOf(const Mesh& mesh) {
    double sum = 0;
    for (const glm::uvec3& t : mesh.triangles)
        sum += 0.5 * glm::length(glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
    return sum;
}

} // namespace

Mesh rectangleMesh() {
    Mesh mesh;
    for (const glm::dvec2 p : {glm::dvec2(-1, -1), glm::dvec2(1, -1), glm::dvec2(1, 1), glm::dvec2(-1, 1)}) {
        mesh.positions.emplace_back(p, 0);
        mesh.uvs.emplace_back(0.5 * (p + 1.0));
    }
    mesh.normals.assign(4, {0, 0, 1});
    mesh.triangles = {{0, 1, 2}, {2, 3, 0}};
    return mesh;
}

Mesh cubeMesh() {
    // The corners of each face, in the order in which texture coordinates go round.
    constexpr int kFaces[6][4][3] = {
        {{1, -1, -1}, {1, -1, 1}, {-1, -1, 1}, {-1, -1, -1}}, {{1, 1, -1}, {-1, 1, -1}, {-1, 1, 1}, {1, 1, 1}},
        {{1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1}},     {{1, -1, 1}, {1, 1, 1}, {-1, 1, 1}, {-1, -1, 1}},
        {{-1, -1, 1}, {-1, 1, 1}, {-1, 1, -1}, {-1, -1, -1}}, {{1, 1, -1}, {1, -1, -1}, {-1, -1, -1}, {-1, 1, -1}}};
    constexpr glm::vec2 kUvs[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    Mesh mesh;
    for (const auto& face : kFaces) {
        const auto first = std::uint32_t(mesh.positions.size());
        glm::vec3 normal(0);
        for (int k = 0; k < 4; ++k) {
            mesh.positions.emplace_back(face[k][0], face[k][1], face[k][2]);
            mesh.uvs.push_back(kUvs[k]);
            normal += glm::vec3(mesh.positions.back()) * 0.25f; // the middle of the face
        }
        mesh.normals.insert(mesh.normals.end(), 4, normal);
        mesh.triangles.emplace_back(first, first + 1, first + 2);
        mesh.triangles.emplace_back(first + 3, first, first + 2);
    }
    return mesh;
}

Mesh diskMesh() {
    Mesh mesh;
    const double radius = std::sqrt(kPi / (0.5 * kSegments * std::sin(2 * kPi / kSegments)));
    // A centre for each triangle: its texture coordinate is the radius and the turn, which has no value there.
    for (int i = 0; i < kSegments; ++i) {
        const double turn = double(i) / kSegments, next = double(i + 1) / kSegments;
        const auto first = std::uint32_t(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {glm::dvec3(0), glm::dvec3(radius * std::cos(2 * kPi * turn), radius * std::sin(2 * kPi * turn), 0),
                                                     glm::dvec3(radius * std::cos(2 * kPi * next), radius * std::sin(2 * kPi * next), 0)});
        mesh.uvs.insert(mesh.uvs.end(), {glm::vec2(0, 0.5 * (turn + next)), glm::vec2(1, turn), glm::vec2(1, next)});
        mesh.triangles.emplace_back(first, first + 1, first + 2);
    }
    mesh.normals.assign(mesh.positions.size(), {0, 0, 1});
    return mesh;
}

Mesh sphereMesh() {
    Mesh mesh;
    const int rows = kSegments / 2;
    for (int r = 0; r <= rows; ++r)
        for (int c = 0; c <= kSegments; ++c) {
            const double v = double(r) / rows, u = double(c) / kSegments, sine = r == 0 || r == rows ? 0 : std::sin(kPi * v);
            const glm::dvec3 p(sine * std::cos(2 * kPi * u), sine * std::sin(2 * kPi * u), std::cos(kPi * v));
            mesh.positions.push_back(p);
            mesh.normals.emplace_back(p);
            mesh.uvs.emplace_back(u, v);
        }
    addGrid(mesh, kSegments, rows, true);
    const double scale = std::sqrt(4 * kPi / areaOf(mesh));
    for (glm::dvec3& p : mesh.positions)
        p *= scale;
    return mesh;
}

Mesh cylinderMesh() {
    Mesh mesh;
    const double radius = kPi / (kSegments * std::sin(kPi / kSegments));
    for (int r = 0; r <= 1; ++r)
        for (int c = 0; c <= kSegments; ++c) {
            const double u = double(c) / kSegments;
            const glm::dvec3 out(std::cos(2 * kPi * u), std::sin(2 * kPi * u), 0);
            mesh.positions.push_back(radius * out + glm::dvec3(0, 0, r));
            mesh.normals.emplace_back(out);
            mesh.uvs.emplace_back(u, r);
        }
    addGrid(mesh, kSegments, 1, false);
    return mesh;
}

} // namespace cmpg

// Triangles in world space, from whatever file they come.
#include "scene/geometry_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmpg {
namespace {

// Positions are re-centred when the scene lies further from the origin than this many of its diagonals: float32 then still
// resolves 2^-24 * kFarAway of the diagonal.
constexpr double kFarAway = 8;
// A triangle is degenerate when twice its area is below this share of its longest edge squared: float32 coordinates cannot tell
// it from a line.
constexpr double kFlat = 1e-9;

glm::dvec3 chooseCenter(const std::vector<glm::dvec3>& positions) {
    if (positions.empty())
        return glm::dvec3(0);
    glm::dvec3 low(positions[0]), high(positions[0]);
    for (const glm::dvec3& p : positions) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    const glm::dvec3 center = (low + high) * 0.5;
    return glm::length(center) > kFarAway * glm::length(high - low) ? center : glm::dvec3(0);
}

bool degenerate(const Geometry& geometry, const Triangle& triangle) {
    const glm::dvec3 a(geometry.positions[triangle.vertices[0]]), b(geometry.positions[triangle.vertices[1]]),
        c(geometry.positions[triangle.vertices[2]]);
    const double longest = std::max({glm::length(b - a), glm::length(c - a), glm::length(c - b)});
    return !(glm::length(glm::cross(b - a, c - a)) > kFlat * longest * longest);
}

} // namespace

void GeometryBuilder::provide(const Attributes& a) {
    provided_.normals |= a.normals;
    provided_.uv0 |= a.uv0;
    provided_.uv1 |= a.uv1;
    provided_.tangents |= a.tangents;
    provided_.colors |= a.colors;
}

std::uint32_t GeometryBuilder::add(const Vertex& vertex) {
    const auto index = std::uint32_t(positions_.size());
    positions_.push_back(vertex.position);
    built_.normals.push_back(vertex.normal);
    built_.uv0.push_back(vertex.uv0);
    built_.uv1.push_back(vertex.uv1);
    built_.tangents.push_back(vertex.tangent);
    built_.colors.push_back(vertex.color);
    return index;
}

void GeometryBuilder::finish(Scene& scene) {
    Geometry& geometry = scene.geometry;
    scene.center = chooseCenter(positions_);
    geometry.positions.reserve(positions_.size());
    for (const glm::dvec3& p : positions_)
        geometry.positions.emplace_back(p - scene.center);
    geometry.triangles.reserve(triangles_.size());
    for (const Triangle& t : triangles_) {
        if (degenerate(geometry, t))
            ++scene.skippedTriangles;
        else
            geometry.triangles.push_back(t);
    }
    if (provided_.normals)
        geometry.normals = std::move(built_.normals);
    if (provided_.uv0)
        geometry.uv0 = std::move(built_.uv0);
    if (provided_.uv1)
        geometry.uv1 = std::move(built_.uv1);
    if (provided_.tangents)
        geometry.tangents = std::move(built_.tangents);
    if (provided_.colors)
        geometry.colors = std::move(built_.colors);
}

glm::vec3 unitOrZero(const glm::dvec3& v) {
    const double length = glm::length(v);
    return length > 0 && std::isfinite(length) ? glm::vec3(v / length) : glm::vec3(0);
}

glm::dmat3 cofactorMatrix(const glm::dmat3& linear) {
    return {glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]), glm::cross(linear[0], linear[1])};
}

bool fitsFloats(const glm::dvec3& position) {
    for (int k = 0; k < 3; ++k)
        if (!(std::abs(position[k]) < double(std::numeric_limits<float>::max())))
            return false;
    return true;
}

} // namespace cmpg

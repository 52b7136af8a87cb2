// What readers of meshes share: polygons, normals, and complaints.
#include "scene/mitsuba/mesh.h"

#include "base/error.h"
#include "scene/geometry_builder.h"

#include <algorithm>
#include <cmath>

namespace cmpg {

void failMesh(const std::string& name, const std::string& what) {
    throw Error(ErrorKind::Input, name + ": " + what, "the mesh is damaged or was written by a faulty exporter", "export it again");
}

void requireFinite(const Mesh& mesh, const std::string& name) {
    for (const glm::dvec3& p : mesh.positions)
        if (!(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)))
            failMesh(name, "a position is not finite");
    for (const glm::vec2& uv : mesh.uvs)
        if (!(std::isfinite(uv.x) && std::isfinite(uv.y)))
            failMesh(name, "a texture coordinate is not finite");
}

void addPolygon(Mesh& mesh, std::span<const std::uint32_t> corners) {
    for (std::size_t k = 2; k < corners.size(); ++k)
        mesh.triangles.emplace_back(corners[0], corners[k - 1], corners[k]);
}

std::vector<glm::vec3> smoothNormals(std::span<const glm::dvec3> positions, std::span<const glm::uvec3> triangles) {
    std::vector<glm::dvec3> sums(positions.size(), glm::dvec3(0));
    for (const glm::uvec3& t : triangles) {
        const glm::dvec3 normal(unitOrZero(glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x])));
        for (int k = 0; k < 3; ++k) {
            const glm::dvec3 at = positions[t[k]], a = positions[t[(k + 1) % 3]] - at, b = positions[t[(k + 2) % 3]] - at;
            const double lengths = glm::length(a) * glm::length(b);
            if (lengths > 0)
                sums[t[k]] += normal * std::acos(std::clamp(glm::dot(a, b) / lengths, -1.0, 1.0));
        }
    }
    std::vector<glm::vec3> normals(sums.size());
    std::transform(sums.begin(), sums.end(), normals.begin(), unitOrZero);
    return normals;
}

} // namespace cmpg

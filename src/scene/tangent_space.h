// Tangents of triangle meshes by MikkTSpace (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited", and the reference implementation): the tangent
// space that glTF asks for where a file has none, and that normal maps are baked in.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace cmpg {

struct TangentMesh {
    std::vector<glm::vec3> positions, normals; // one a vertex; normals are unit vectors
    std::vector<glm::vec2> uvs;                // one a vertex
    std::vector<std::uint32_t> corners;        // three a triangle, each an index of a vertex
};

// One a corner: xyz the unit tangent, along growing u, perpendicular to the corner's normal; w = +-1: the bitangent, along growing v, is
// w cross(normal, xyz). All zero where texture coordinates give no direction. Vertices of equal position, normal and uv are one; the angle that splits
// tangents of a vertex is MikkTSpace's default of 180 degrees. What is not finite gives no direction. In O(n log n) time and O(n) memory.
std::vector<glm::vec4> mikkTangents(const TangentMesh& mesh);

} // namespace cmpg

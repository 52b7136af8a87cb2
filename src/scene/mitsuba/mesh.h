// Meshes in their own space: of files, and of Mitsuba's analytic shapes.
#pragma once

#include "scene/file_io.h"

#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

struct Mesh {
    std::vector<glm::dvec3> positions;
    std::vector<glm::vec3> normals; // none, or one for each position; zero: the triangle's own
    std::vector<glm::vec2> uvs;     // none, or one for each position; v as Mitsuba counts it, 0 in row 0 of a picture
    std::vector<glm::uvec3> triangles;
};

// Wavefront OBJ and Stanford PLY. `name` of the file stands in messages. Throws Error(Input).
Mesh readObj(const Bytes& file, const std::string& name);
Mesh readPly(const Bytes& file, const std::string& name);

// What readers end a faulty file with, and check at the end.
[[noreturn]] void failMesh(const std::string& name, const std::string& what);
void requireFinite(const Mesh& mesh, const std::string& name);
// As a fan of triangles about its first corner.
void addPolygon(Mesh& mesh, std::span<const std::uint32_t> corners);

// Smooth normals on the sides that corners go round counter-clockwise, weighted by the angles of the triangles at each vertex (Thürmer and Wüthrich 1998).
std::vector<glm::vec3> smoothNormals(std::span<const glm::dvec3> positions, std::span<const glm::uvec3> triangles);

Mesh rectangleMesh(); // [-1, 1]^2 at z = 0, faces +z
Mesh cubeMesh();      // [-1, 1]^3
// Round shapes as polyhedra of the same area: what they send out and receive is right on average, and their outline lies on both sides of the
// true one, by less than 0.2 % of the radius.
Mesh diskMesh();      // radius 1 at z = 0, faces +z
Mesh sphereMesh();    // radius 1
Mesh cylinderMesh();  // radius 1 about z from 0 to 1, open, faces out

} // namespace cmpg

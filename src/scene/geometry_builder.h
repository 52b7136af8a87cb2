// Triangles in world space, from whatever file they come.
#pragma once

#include "scene/scene.h"

namespace cmpg {

struct Vertex {
    glm::dvec3 position{0};
    glm::vec3 normal{0}; // unit; zero: the triangle's own
    glm::vec2 uv0{0}, uv1{0};
    glm::vec4 tangent{0}; // xyz unit, w = +-1; zero: from the texture coordinates
    glm::vec4 color{1};
};

// Grows with every mesh; positions stay in double until the centre is known.
class GeometryBuilder {
  public:
    // Which attributes the vertices of some mesh have; those of none are not kept.
    struct Attributes {
        bool normals = false, uv0 = false, uv1 = false, tangents = false, colors = false;
    };
    void provide(const Attributes& attributes);

    std::uint32_t add(const Vertex& vertex); // returns its index
    void add(const Triangle& triangle) { triangles_.push_back(triangle); }
    std::size_t triangles() const { return triangles_.size(); }

    // Fills geometry, centre and number of degenerate triangles of a scene.
    void finish(Scene& scene);

  private:
    Attributes provided_;
    std::vector<glm::dvec3> positions_;
    Geometry built_; // all but positions and triangles
    std::vector<Triangle> triangles_;
};

// The vector as a unit one; zero where it has no direction.
glm::vec3 unitOrZero(const glm::dvec3& v);

// Transforms normals even where `linear` squashes a dimension to nothing.
glm::dmat3 cofactorMatrix(const glm::dmat3& linear);

// Whether all coordinates fit into a float.
bool fitsFloats(const glm::dvec3& position);

} // namespace cmpg

// Where the camera rays of a pass met the scene first.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace cmpg {

struct FirstVertex {
    std::uint32_t material; // index into Scene::materials; kNoMaterial: the ray left the scene
    glm::vec2 uv0, uv1;     // texture coordinates of the point; the environment's, and (0, 0)
};

struct FirstVertices {
    std::vector<std::size_t> begin;    // of pixel p: vertices [begin[p], begin[p + 1])
    std::vector<FirstVertex> vertices; // one for each camera ray
};

} // namespace cmpg

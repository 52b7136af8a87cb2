// Bounding volume hierarchy over triangles: deterministic whatever the thread count.
#pragma once

#include "scene/scene.h"
#include "shared/bvh_node.h"

namespace cmpg {

struct Bvh {
    std::vector<gpu::BvhNode> nodes;       // node 0 is the root
    std::vector<std::uint32_t> order;      // order[i] = index of the scene triangle that stands at place i of the leaves
    std::uint32_t depth = 0;
    float sahCost = 0;
};

// Binned surface-area heuristic, leaves of at most kMaxLeafTriangles. An empty scene gives one empty leaf.
Bvh buildBvh(const Geometry& geometry, unsigned threads = 0);

} // namespace cmpg

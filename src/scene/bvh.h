// Bounding volume hierarchy over triangles: deterministic whatever the thread count.
#pragma once

#include "scene/scene.h"
#include "shared/bvh_node.h"

namespace cmpg {

struct Bvh {
    std::vector<gpu::BvhNode> nodes;  // node 0 is the root; leaf blocks (gpu::LeafBlock) stand among the box nodes
    std::vector<std::uint32_t> order; // order[i] = index of the scene triangle that is number i in BVH order
    std::uint32_t depth = 0;          // box nodes on the longest path, at most gpu::kMaxBvhDepth
    std::uint32_t blocks = 0;         // how many of `nodes` are leaf blocks
    float sahCost = 0;                // expected records read by a random ray that meets the root's box
};

// Binned surface-area heuristic, leaves of at most kMaxLeafTriangles. An empty scene gives a root nothing can enter.
// Positions must be finite. threads = 0: as many as the machine has.
Bvh buildBvh(const Geometry& geometry, unsigned threads = 0);

} // namespace cmpg

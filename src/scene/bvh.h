// Bounding volume hierarchy over triangles: deterministic whatever the thread count.
#pragma once

#include "scene/scene.h"
#include "shared/bvh_node.h"

namespace cmpg {

// A gpu::BvhNode or a gpu::LeafBlock; the parent tells which.
using BvhRecord = std::array<std::uint32_t, 16>;

struct Bvh {
    std::vector<BvhRecord> records;   // record 0 is the root, a box node
    std::vector<std::uint32_t> order; // order[i] = index of the scene triangle that is number i in BVH order
    std::uint32_t depth = 0;          // box nodes on the longest path, at most gpu::kMaxBvhDepth
    std::uint32_t blocks = 0;         // how many records are leaf blocks
    float sahCost = 0;                // expected records read by a random line that meets the root's box
};

// Binned surface-area heuristic. An empty scene gives a root without children. Positions must be finite.
// threads = 0: as many as the machine has.
Bvh buildBvh(const Geometry& geometry, unsigned threads = 0);

} // namespace cmpg

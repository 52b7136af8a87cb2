// Makes a binary tree cheaper: subtrees that lie badly are taken out and put in where the boxes grow least.
#pragma once

#include "scene/bvh_split.h"

namespace cmpg {

struct RefinedTree {
    SplitTree tree;
    std::vector<Reference> references; // in its order; empty where nothing was gained
};

// Reinsertion (Bittner, Hapala, Havran 2013; in batches: Meister and Bittner 2018). The surface-area heuristic splits from above and never looks back; this moves
// single subtrees of its result while that lowers the sum of the boxes' areas. Leaves stay whole. The result is the same for every thread count. No path
// from the root is longer than `depth` nodes, unless one was.
RefinedTree refine(const SplitTree& tree, const std::vector<Reference>& references, std::uint32_t depth);

} // namespace cmpg

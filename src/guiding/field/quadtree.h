// Quadtrees over directions: made, summed, and fitted to where their mass lies. Children follow their parents in every list of nodes.
#pragma once

#include "guiding/field/sd_tree.h"

namespace cmpg {

// Which quadrants have children after a refinement.
struct QuadRefinement {
    double share;           // those with a larger share of any mass of the tree,
    std::uint32_t maxDepth; // unless they lie this deep; the root's quadrants have depth 1
};

// Nodes of a tree after its refinement, and how many of them exist already.
struct QuadDemand {
    std::uint64_t wanted = 1, kept = 1;
};

// 1 + 4 + ... nodes whose leaves lie `depth` (at least 1) levels below the square; all masses 0.
std::vector<QuadNode> regularQuadtree(std::uint32_t depth);

GuideMass total(const QuadNode& node); // in the order of the quadrants

// Masses of inner quadrants from their children's.
void sumUp(std::vector<QuadNode>& nodes);

QuadDemand demand(const std::vector<QuadNode>& nodes, const QuadRefinement& refinement);

// New children get a quarter of their quadrant's masses each; collapsed quadrants keep what their children had. Level by level, so
// that the deepest nodes are left out where `limit` nodes are not enough.
std::vector<QuadNode> refined(const std::vector<QuadNode>& nodes, const QuadRefinement& refinement, std::uint64_t limit);

// Empty, or what is wrong with one tree.
std::string validateQuadtree(const std::vector<QuadNode>& nodes, std::uint32_t maxDepth);

} // namespace cmpg

// Collapses a binary tree into nodes of kBvhWidth children.
#pragma once

#include "scene/bvh_split.h"
#include "shared/bvh_node.h"

#include <array>
#include <cstddef>
#include <utility>

namespace cmpg {

// A subtree of the binary tree: a leaf, or what a wide node stands for.
struct Subtree {
    Box box;
    std::uint32_t slot, begin, end; // as in SplitNode
    bool leaf;

    std::uint32_t records() const { return leaf ? end - begin : 1; }
};

// The cheapest such collapse by the surface-area heuristic (Ylitie, Karras, Laine 2017), found from the leaves up. Leaves stay whole.
class Collapse {
  public:
    Collapse(const SplitTree& tree, std::size_t references); // `tree` outlives this
    Subtree root() const;
    // Of a wide node, or the one child of a root that is a leaf. Returns how many.
    std::uint32_t children(const Subtree& node, std::array<Subtree, gpu::kBvhWidth>& children) const;
    // Of a line that meets the root, times the root's area, in tests of leaf blocks.
    float cost() const { return cost_; }

  private:
    // [k - 1]: of a subtree as at most k children of one node.
    using Costs = std::array<float, gpu::kBvhWidth>;
    // How many of them are below the left half; [k - 1] is 0 where fewer than k are as cheap, [0] is that of the node's own children.
    using Shares = std::array<std::uint8_t, gpu::kBvhWidth>;

    std::pair<Subtree, Subtree> halves(const Subtree& t) const;
    Costs measure(const Subtree& t);
    void gather(const Subtree& t, std::uint32_t most, std::array<Subtree, gpu::kBvhWidth>& children, std::uint32_t& count) const;
    void gatherHalves(const Subtree& t, std::uint32_t left, std::uint32_t most, std::array<Subtree, gpu::kBvhWidth>& children, std::uint32_t& count) const;

    const SplitTree* tree_;
    std::uint32_t references_;
    std::vector<Shares> shares_; // by slot
    float cost_;
};

} // namespace cmpg

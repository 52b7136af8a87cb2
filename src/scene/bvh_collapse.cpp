// The cheapest collapse of a binary tree, by dynamic programming.
#include "scene/bvh_collapse.h"

#include <algorithm>
#include <limits>

namespace cmpg {
namespace {

constexpr float kNodeCost = 1.5f; // of a box node, relative to a leaf block; three splits of the binary tree (kSplitCost)

} // namespace

Collapse::Collapse(const SplitTree& tree, std::size_t references)
    : tree_(&tree), references_(std::uint32_t(references)), shares_(tree.slots.size()), cost_(measure(root())[0]) {}

Subtree Collapse::root() const { return {tree_->box, 0, 0, references_, tree_->single}; }

std::pair<Subtree, Subtree> Collapse::halves(const Subtree& t) const {
    const SplitNode& split = tree_->slots[t.slot];
    return {{split.left, t.slot + 1, t.begin, split.middle, split.leftLeaf},
            {split.right, t.slot + (split.middle - t.begin), split.middle, t.end, split.rightLeaf}};
}

Collapse::Costs Collapse::measure(const Subtree& t) {
    const float area = t.box.halfArea();
    Costs costs;
    if (t.leaf) {
        costs.fill(area * float(t.records()));
        return costs;
    }
    const auto [left, right] = halves(t);
    const Costs a = measure(left), b = measure(right);
    Shares& shares = shares_[t.slot];
    // Into at most k children, with some in both halves.
    const auto split = [&](std::uint32_t k) {
        std::pair<float, std::uint8_t> best{std::numeric_limits<float>::infinity(), std::uint8_t(1)};
        for (std::uint32_t i = 1; i < k; ++i)
            if (const float c = a[i - 1] + b[k - i - 1]; c < best.first)
                best = {c, std::uint8_t(i)};
        return best;
    };
    const auto [below, own] = split(gpu::kBvhWidth);
    costs[0] = kNodeCost * area + below;
    shares[0] = own;
    for (std::uint32_t k = 2; k <= gpu::kBvhWidth; ++k) {
        const auto [c, i] = split(k);
        const bool cheaper = c < costs[k - 2];
        costs[k - 1] = cheaper ? c : costs[k - 2];
        shares[k - 1] = cheaper ? i : std::uint8_t(0);
    }
    return costs;
}

void Collapse::gather(const Subtree& t, std::uint32_t most, std::array<Subtree, gpu::kBvhWidth>& children, std::uint32_t& count) const {
    while (most > 1 && !t.leaf && shares_[t.slot][most - 1] == 0)
        --most;
    if (most == 1 || t.leaf)
        children[count++] = t;
    else
        gatherHalves(t, shares_[t.slot][most - 1], most, children, count);
}

void Collapse::gatherHalves(const Subtree& t, std::uint32_t left, std::uint32_t most, std::array<Subtree, gpu::kBvhWidth>& children, std::uint32_t& count) const {
    const auto [a, b] = halves(t);
    gather(a, left, children, count);
    gather(b, most - left, children, count);
}

std::uint32_t Collapse::children(const Subtree& node, std::array<Subtree, gpu::kBvhWidth>& children) const {
    std::uint32_t count = 0;
    if (node.leaf)
        children[count++] = node;
    else
        gatherHalves(node, shares_[node.slot][0], gpu::kBvhWidth, children, count);
    return count;
}

} // namespace cmpg

// Quadtrees over directions: made, summed, and fitted to where their mass lies.
#include "guiding/field/quadtree.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

// Decides which quadrants have children.
class Splitter {
  public:
    Splitter(const QuadNode& root, const QuadRefinement& refinement)
        : threshold_(total(root) * refinement.share), maxDepth_(refinement.maxDepth) {}

    bool operator()(const GuideMass& m, std::uint32_t depth) const {
        return depth < maxDepth_ && (m.primal > threshold_.primal || m.plus > threshold_.plus || m.minus > threshold_.minus);
    }

  private:
    GuideMass threshold_;
    std::uint32_t maxDepth_;
};

// Nodes of a new subtree under a quadrant of mass m: its four quarters are alike.
std::uint64_t newNodes(const Splitter& splits, const GuideMass& m, std::uint32_t depth) {
    return splits(m, depth) ? 1 + 4 * newNodes(splits, m * 0.25, depth + 1) : 0;
}

bool valid(double mass) { return std::isfinite(mass) && mass >= 0; }

// Sums are made again in the same order after every change, so they agree to the last bit but for what quartering loses near zero.
bool agree(double sum, double parts) { return std::abs(sum - parts) <= 1e-12 * sum + 1e-300; }

} // namespace

std::vector<QuadNode> regularQuadtree(std::uint32_t depth) {
    std::uint32_t count = 1, inner = 0;
    for (std::uint32_t level = 1, width = 1; level < depth; ++level, width *= 4) {
        inner += width;
        count += width * 4;
    }
    std::vector<QuadNode> nodes(count);
    for (std::uint32_t i = 0; i < inner; ++i)
        for (std::uint32_t q = 0; q < 4; ++q)
            nodes[i].child[q] = 4 * i + q + 1;
    return nodes;
}

GuideMass total(const QuadNode& node) {
    GuideMass sum;
    for (const GuideMass& m : node.mass)
        sum += m;
    return sum;
}

void sumUp(std::vector<QuadNode>& nodes) {
    for (std::size_t i = nodes.size(); i-- > 0;)
        for (std::uint32_t q = 0; q < 4; ++q)
            if (nodes[i].child[q])
                nodes[i].mass[q] = total(nodes[nodes[i].child[q]]);
}

QuadDemand demand(const std::vector<QuadNode>& nodes, const QuadRefinement& refinement) {
    const Splitter splits(nodes[0], refinement);
    QuadDemand result;
    const auto visit = [&](const auto& self, const QuadNode& node, std::uint32_t depth) -> void {
        for (std::uint32_t q = 0; q < 4; ++q) {
            if (!node.child[q]) {
                result.wanted += newNodes(splits, node.mass[q], depth);
            } else if (splits(node.mass[q], depth)) {
                ++result.wanted;
                ++result.kept;
                self(self, nodes[node.child[q]], depth + 1);
            }
        }
    };
    visit(visit, nodes[0], 1);
    return result;
}

std::vector<QuadNode> refined(const std::vector<QuadNode>& nodes, const QuadRefinement& refinement, std::uint64_t limit) {
    const Splitter splits(nodes[0], refinement);
    struct Origin {
        std::uint32_t old = 0;   // the node it comes from
        std::uint32_t depth = 1; // of its quadrants
        bool made = false;       // it comes from none
    };
    std::vector<QuadNode> result = {nodes[0]};
    std::vector<Origin> origins = {{}};
    for (std::size_t i = 0; i < result.size(); ++i) {
        const Origin origin = origins[i];
        for (std::uint32_t q = 0; q < 4; ++q) {
            const std::uint32_t oldChild = origin.made ? 0 : nodes[origin.old].child[q];
            result[i].child[q] = 0;
            if (result.size() >= limit || !splits(result[i].mass[q], origin.depth))
                continue;
            QuadNode child;
            child.mass.fill(result[i].mass[q] * 0.25);
            result[i].child[q] = std::uint32_t(result.size());
            result.push_back(oldChild ? nodes[oldChild] : child);
            origins.push_back({oldChild, origin.depth + 1, oldChild == 0});
        }
    }
    sumUp(result);
    return result;
}

std::string validateQuadtree(const std::vector<QuadNode>& nodes, std::uint32_t maxDepth) {
    if (nodes.empty())
        return "has no nodes";
    std::vector<std::uint32_t> depth(nodes.size(), 0); // of the node's quadrants; 0: not reached yet
    depth[0] = 1;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const std::string name = "node " + std::to_string(i);
        std::uint32_t expected = 0; // the next child
        if (!depth[i])
            return name + " is nobody's child";
        if (depth[i] > std::max(maxDepth, 1u))
            return name + " lies too deep";
        for (std::uint32_t q = 0; q < 4; ++q) {
            const GuideMass& m = nodes[i].mass[q];
            if (!valid(m.primal) || !valid(m.plus) || !valid(m.minus))
                return name + " has a negative or non-finite mass";
            const std::uint32_t child = nodes[i].child[q];
            if (!child)
                continue;
            if (child <= i || child >= nodes.size())
                return name + " has a child out of range";
            if (expected && child != expected)
                return name + " has children that do not lie side by side";
            expected = child + 1;
            if (depth[child])
                return "node " + std::to_string(child) + " has two parents";
            depth[child] = depth[i] + 1;
            const GuideMass parts = total(nodes[child]);
            if (!agree(m.primal, parts.primal) || !agree(m.plus, parts.plus) || !agree(m.minus, parts.minus))
                return name + " is not the sum of its children";
        }
    }
    return {};
}

} // namespace cmpg

// Reinsertion of subtrees, in batches whose searches run side by side and whose moves are made in a fixed order.
#include "scene/bvh_refine.h"

#include "base/parallel.h"

#include <algorithm>
#include <array>
#include <utility>

namespace cmpg {
namespace {

constexpr std::uint32_t kNone = ~0u;
constexpr int kBatches = 4;
constexpr float kLeastGain = 0.005f; // of all areas: a batch that finds less is the last
constexpr std::size_t kMostMoves = 1 << 14; // searched in a batch: those of the largest boxes, which rays meet most

struct Node {
    Box box;
    std::uint32_t parent = kNone;
    std::array<std::uint32_t, 2> children{kNone, kNone}; // none: a leaf
    std::uint32_t begin = 0, end = 0;                    // of a leaf: its references

    bool leaf() const { return children[0] == kNone; }
};

Box merged(Box a, const Box& b) {
    a.grow(b);
    return a;
}

struct Move {
    float gain = 0;             // by which the sum of areas falls
    std::uint32_t to = kNone; // becomes the sibling of this one
};

class Refiner {
  public:
    Refiner(const SplitTree& tree, const std::vector<Reference>& references, std::uint32_t depth) : tree_(tree), references_(references), depth_(depth) {}

    RefinedTree run() {
        nodes_.reserve(2 * tree_.slots.size());
        const std::uint32_t before = take(kNone, tree_.box, 0, 0, std::uint32_t(references_.size()), tree_.single);
        float areas = 0;
        for (const Node& node : nodes_)
            areas += node.box.halfArea();
        float gained = 0;
        for (int batch = 0; batch < kBatches; ++batch) {
            const float gain = moveBatch();
            gained += gain;
            if (gain <= kLeastGain * areas)
                break;
        }
        return gained > 0 && height() <= std::max(depth_, before) ? result() : RefinedTree();
    }

  private:
    // Nodes of the tree below a range, the root first. Returns the nodes on the longest path.
    std::uint32_t take(std::uint32_t parent, const Box& box, std::uint32_t slot, std::uint32_t begin, std::uint32_t end, bool leaf) {
        const auto index = std::uint32_t(nodes_.size());
        nodes_.push_back({box, parent, {kNone, kNone}, begin, end});
        if (leaf)
            return 1;
        const SplitNode& split = tree_.slots[slot];
        nodes_[index].children[0] = std::uint32_t(nodes_.size());
        const std::uint32_t left = take(index, split.left, slot + 1, begin, split.middle, split.leftLeaf);
        nodes_[index].children[1] = std::uint32_t(nodes_.size());
        return 1 + std::max(left, take(index, split.right, slot + (split.middle - begin), split.middle, end, split.rightLeaf));
    }

    std::uint32_t sibling(std::uint32_t node) const {
        const auto& pair = nodes_[nodes_[node].parent].children;
        return pair[pair[0] == node];
    }

    // The best place for a subtree. Taking it out makes its parent go and the boxes above shrink; putting it beside a node makes one box
    // around both and lets those above grow. Walks up from where it is, and down into every subtree that may still gain.
    Move search(std::uint32_t node, std::vector<std::pair<float, std::uint32_t>>& stack) const {
        Move best;
        const Box& box = nodes_[node].box;
        const float area = box.halfArea();
        std::uint32_t pivot = nodes_[node].parent, from = sibling(node);
        float saved = nodes_[pivot].box.halfArea(); // by the boxes that have gone or shrunk
        Box shrunk = nodes_[from].box;              // of the pivot, without the subtree
        while (true) {
            stack.emplace_back(saved, from);
            while (!stack.empty()) {
                const auto [gain, at] = stack.back();
                stack.pop_back();
                if (gain - area <= best.gain)
                    continue;
                const float both = merged(nodes_[at].box, box).halfArea();
                if (gain - both > best.gain)
                    best = {gain - both, at};
                if (!nodes_[at].leaf()) {
                    const float below = gain - (both - nodes_[at].box.halfArea());
                    if (below - area > best.gain)
                        for (const std::uint32_t child : nodes_[at].children)
                            stack.emplace_back(below, child);
                }
            }
            if (nodes_[pivot].parent == kNone)
                break;
            if (pivot != nodes_[node].parent)
                saved += nodes_[pivot].box.halfArea() - shrunk.halfArea();
            from = sibling(pivot);
            shrunk.grow(nodes_[from].box);
            pivot = nodes_[pivot].parent;
        }
        if (best.to == sibling(node) || best.to == nodes_[node].parent)
            return {};
        return best;
    }

    // Returns by how much the sum of areas fell.
    float moveBatch() {
        // Children of the root stay: their places are the whole tree.
        std::vector<std::uint32_t> order;
        for (std::uint32_t i = 1; i < nodes_.size(); ++i)
            if (nodes_[i].parent != 0)
                order.push_back(i);
        const auto larger = [&](std::uint32_t a, std::uint32_t b) {
            const float x = nodes_[a].box.halfArea(), y = nodes_[b].box.halfArea();
            return x > y || (x == y && a < b);
        };
        const std::size_t count = std::min(order.size(), kMostMoves);
        std::nth_element(order.begin(), order.begin() + std::ptrdiff_t(count), order.end(), larger);
        order.resize(count);
        std::sort(order.begin(), order.end());
        std::vector<Move> moves(count);
        parallelFor(count, 256, [&](std::size_t begin, std::size_t end) {
            std::vector<std::pair<float, std::uint32_t>> stack;
            for (std::size_t i = begin; i < end; ++i)
                moves[i] = search(order[i], stack);
        });
        std::vector<std::uint32_t> best;
        for (std::uint32_t i = 0; i < count; ++i)
            if (moves[i].to != kNone)
                best.push_back(i);
        std::sort(best.begin(), best.end(), [&](std::uint32_t a, std::uint32_t b) { return moves[a].gain > moves[b].gain || (moves[a].gain == moves[b].gain && a < b); });
        // A move counts on the nodes around both of its ends: others that want the same ones wait for the next batch.
        std::vector<bool> touched(nodes_.size());
        float gain = 0;
        for (const std::uint32_t i : best) {
            const std::uint32_t node = order[i], to = moves[i].to, parent = nodes_[node].parent;
            const std::array<std::uint32_t, 6> ends{node, sibling(node), parent, nodes_[parent].parent, to, nodes_[to].parent};
            if (std::any_of(ends.begin(), ends.end(), [&](std::uint32_t n) { return n == kNone || touched[n]; }))
                continue;
            for (const std::uint32_t n : ends)
                touched[n] = true;
            gain += move(node, to) ? moves[i].gain : 0;
        }
        return gain;
    }

    bool isBelow(std::uint32_t node, std::uint32_t above) const {
        for (; node != kNone; node = nodes_[node].parent)
            if (node == above)
                return true;
        return false;
    }

    void replaceChild(std::uint32_t parent, std::uint32_t old, std::uint32_t child) {
        auto& pair = nodes_[parent].children;
        pair[pair[1] == old] = child;
        nodes_[child].parent = parent;
    }

    // The parent goes along: its sibling takes its place, and it becomes the node above both at the other end.
    // Not where a move before this one brought that end below the subtree.
    bool move(std::uint32_t node, std::uint32_t to) {
        if (isBelow(to, node))
            return false;
        const std::uint32_t parent = nodes_[node].parent, above = nodes_[parent].parent, other = sibling(node);
        replaceChild(above, parent, other);
        replaceChild(nodes_[to].parent, to, parent);
        nodes_[parent].children = {to, node};
        nodes_[to].parent = parent;
        refit(above);
        refit(parent);
        return true;
    }

    void refit(std::uint32_t node) {
        for (; node != kNone; node = nodes_[node].parent) {
            const auto& [a, b] = nodes_[node].children;
            nodes_[node].box = merged(nodes_[a].box, nodes_[b].box);
        }
    }

    // Nodes on the longest path.
    std::uint32_t height() const {
        std::uint32_t most = 0;
        for (const Node& node : nodes_)
            if (node.leaf()) {
                std::uint32_t length = 1;
                for (std::uint32_t up = node.parent; up != kNone; up = nodes_[up].parent)
                    ++length;
                most = std::max(most, length);
            }
        return most;
    }

    RefinedTree result() const {
        RefinedTree made;
        made.references.reserve(references_.size());
        made.tree.box = tree_.box;
        made.tree.single = tree_.single;
        made.tree.slots.resize(tree_.slots.size());
        place(0, 0, made);
        return made;
    }

    void place(std::uint32_t node, std::uint32_t slot, RefinedTree& made) const {
        const Node& n = nodes_[node];
        std::vector<Reference>& ordered = made.references;
        if (n.leaf()) {
            ordered.insert(ordered.end(), references_.begin() + n.begin, references_.begin() + n.end);
            return;
        }
        const auto begin = std::uint32_t(ordered.size());
        place(n.children[0], slot + 1, made);
        const auto middle = std::uint32_t(ordered.size());
        place(n.children[1], slot + (middle - begin), made);
        const Node &left = nodes_[n.children[0]], &right = nodes_[n.children[1]];
        made.tree.slots[slot] = {left.box, right.box, middle, left.leaf(), right.leaf()};
    }

    const SplitTree& tree_;
    const std::vector<Reference>& references_;
    std::uint32_t depth_;
    std::vector<Node> nodes_;
};

} // namespace

RefinedTree refine(const SplitTree& tree, const std::vector<Reference>& references, std::uint32_t depth) {
    return tree.single ? RefinedTree() : Refiner(tree, references, depth).run();
}

} // namespace cmpg

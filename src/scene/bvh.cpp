// Builds the hierarchy: pairs triangles into blocks, splits the blocks, writes the records the kernels read.
#include "scene/bvh.h"

#include "scene/bvh_split.h"

#include <algorithm>
#include <bit>
#include <thread>

namespace cmpg {
namespace {

static_assert(sizeof(gpu::BvhNode) == 64 && sizeof(gpu::LeafBlock) == 64);

constexpr std::uint32_t kNoTriangle = ~0u;
// A pair shares one box; it is made where that box costs less than the two apart.
constexpr float kPairArea = 0.9f;
// How far ahead a partner is looked for: exporters write the halves of a quad, and the triangles of a strip, side by side.
constexpr std::uint32_t kPairWindow = 3;

struct Pair {
    std::uint32_t a, b; // b may be kNoTriangle
};

struct Corners {
    glm::vec3 p[3];
};

// Where two triangles share an edge: corner a0 of A follows corner a2 along it; B starts at the same corner.
struct SharedEdge {
    bool found = false;
    std::uint32_t turnA = 0, turnB = 0; // corner that comes first in the block
    bool flipB = false;
};

Corners corners(const Geometry& g, std::uint32_t triangle) {
    const auto& v = g.triangles[triangle].vertices;
    return {{g.positions[v[0]], g.positions[v[1]], g.positions[v[2]]}};
}

Box boxOf(const Corners& c) {
    Box box;
    for (const glm::vec3& p : c.p)
        box.grow(p);
    return box;
}

// By position, not by index: seams of texture coordinates duplicate vertices.
SharedEdge sharedEdge(const Corners& a, const Corners& b) {
    for (std::uint32_t i = 0; i < 3; ++i) // A's first corner in the block is i, its last is i + 2; B runs from i to i + 2
        for (std::uint32_t j = 0; j < 3; ++j) {
            if (a.p[i] != b.p[j])
                continue;
            const glm::vec3& last = a.p[(i + 2) % 3];
            if (last == b.p[(j + 1) % 3])
                return {true, i, j, false};
            if (last == b.p[(j + 2) % 3])
                return {true, i, j, true};
        }
    return {};
}

void pairTriangles(const Geometry& g, std::vector<Pair>& pairs, std::vector<Reference>& references) {
    const std::uint32_t n = std::uint32_t(g.triangles.size());
    std::vector<bool> taken(n);
    pairs.reserve(n);
    references.reserve(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        if (taken[i])
            continue;
        const Corners a = corners(g, i);
        Box box = boxOf(a);
        std::uint32_t partner = kNoTriangle;
        for (std::uint32_t k = i + 1; k < std::min(n, i + 1 + kPairWindow) && partner == kNoTriangle; ++k) {
            if (taken[k])
                continue;
            const Corners b = corners(g, k);
            if (!sharedEdge(a, b).found)
                continue;
            const Box own = boxOf(b);
            Box both = box;
            both.grow(own);
            if (both.halfArea() > kPairArea * (box.halfArea() + own.halfArea()))
                continue;
            partner = k;
            taken[k] = true;
            box = both;
        }
        references.push_back({box.low, std::uint32_t(pairs.size()), box.high, partner == kNoTriangle ? 1u : 2u});
        pairs.push_back({i, partner});
    }
}

// Writes records in depth-first order, so that a descent mostly moves forward in memory.
class Writer {
  public:
    Writer(const Geometry& geometry, const SplitTree& tree, const std::vector<Pair>& pairs, const std::vector<Reference>& references, Bvh& bvh)
        : geometry_(geometry), tree_(tree), pairs_(pairs), references_(references), bvh_(bvh) {
        const glm::vec3 reach = glm::max(glm::abs(tree.box.low), glm::abs(tree.box.high));
        // The triangle test rounds in units of the distance to the ray's origin; a ray accepted just outside a triangle must have
        // met its box. Eight units in the last place of the largest coordinate are more than those roundings together.
        padding_ = 8 * 6e-8f * std::max({reach.x, reach.y, reach.z});
        rootArea_ = std::max(tree.box.halfArea(), std::numeric_limits<float>::min());
    }

    void run() {
        if (tree_.single) {
            gpu::BvhNode& root = bvh_.nodes.emplace_back();
            setBox(root.leftLow, root.leftHigh, tree_.box);
            setBox(root.rightLow, root.rightHigh, Box{});
            bvh_.depth = 1;
            cost_ = 1;
            if (!references_.empty()) {
                const std::uint32_t leaf = writeLeaf(0, std::uint32_t(references_.size()), 1);
                bvh_.nodes[0].left = bvh_.nodes[0].right = leaf;
            }
        } else {
            writeNode(0, 0, std::uint32_t(references_.size()), 1, 1);
        }
        bvh_.sahCost = float(cost_);
    }

  private:
    void setBox(glm::vec3& low, glm::vec3& high, const Box& box) const {
        const bool empty = !(box.low.x <= box.high.x);
        low = empty ? glm::vec3(1) : box.low - padding_;
        high = empty ? glm::vec3(-1) : box.high + padding_;
    }

    std::uint32_t writeNode(std::uint32_t slot, std::uint32_t begin, std::uint32_t end, std::uint32_t depth, float chance) {
        const SplitNode& split = tree_.slots[slot];
        const std::uint32_t index = std::uint32_t(bvh_.nodes.size());
        bvh_.nodes.emplace_back();
        bvh_.depth = std::max(bvh_.depth, depth);
        cost_ += chance;
        const float leftChance = split.left.halfArea() / rootArea_, rightChance = split.right.halfArea() / rootArea_;
        const std::uint32_t left = split.leftLeaf ? writeLeaf(begin, split.middle, leftChance)
                                                  : writeNode(slot + 1, begin, split.middle, depth + 1, leftChance);
        const std::uint32_t right = split.rightLeaf ? writeLeaf(split.middle, end, rightChance)
                                                    : writeNode(slot + (split.middle - begin), split.middle, end, depth + 1, rightChance);
        gpu::BvhNode& node = bvh_.nodes[index];
        setBox(node.leftLow, node.leftHigh, split.left);
        setBox(node.rightLow, node.rightHigh, split.right);
        node.left = left;
        node.right = right;
        return index;
    }

    std::uint32_t writeLeaf(std::uint32_t begin, std::uint32_t end, float chance) {
        const std::uint32_t first = std::uint32_t(bvh_.nodes.size());
        for (std::uint32_t i = begin; i < end; ++i)
            writeBlock(pairs_[references_[i].item]);
        auto& last = reinterpret_cast<gpu::LeafBlock&>(bvh_.nodes.back());
        last.turns |= gpu::kLastBlock;
        const std::uint32_t blocks = std::uint32_t(bvh_.nodes.size()) - first;
        bvh_.blocks += blocks;
        cost_ += double(chance) * blocks;
        return first | gpu::kLeafBit;
    }

    void writeBlock(const Pair& pair) {
        const Corners a = corners(geometry_, pair.a);
        gpu::LeafBlock block{};
        block.first = std::uint32_t(bvh_.order.size());
        bvh_.order.push_back(pair.a);
        SharedEdge edge;
        if (pair.b != kNoTriangle) {
            const Corners b = corners(geometry_, pair.b);
            edge = sharedEdge(a, b);
            block.v3 = b.p[(edge.turnB + (edge.flipB ? 1 : 2)) % 3];
            bvh_.order.push_back(pair.b);
        } else {
            block.v3 = a.p[2];
        }
        block.v0 = a.p[edge.turnA];
        block.v1 = a.p[(edge.turnA + 1) % 3];
        block.v2 = a.p[(edge.turnA + 2) % 3];
        block.turns = edge.turnA | (edge.turnB | (edge.flipB ? 4u : 0u)) << 4;
        bvh_.nodes.push_back(std::bit_cast<gpu::BvhNode>(block));
    }

    const Geometry& geometry_;
    const SplitTree& tree_;
    const std::vector<Pair>& pairs_;
    const std::vector<Reference>& references_;
    Bvh& bvh_;
    float padding_, rootArea_;
    double cost_ = 0;
};

} // namespace

Bvh buildBvh(const Geometry& geometry, unsigned threads) {
    std::vector<Pair> pairs;
    std::vector<Reference> references;
    pairTriangles(geometry, pairs, references);
    const SplitTree tree = splitReferences(references, threads ? threads : std::max(1u, std::thread::hardware_concurrency()));

    Bvh bvh;
    bvh.order.reserve(geometry.triangles.size());
    bvh.nodes.reserve(references.size() * 2);
    Writer(geometry, tree, pairs, references, bvh).run();
    return bvh;
}

} // namespace cmpg

// Builds the hierarchy: pairs triangles into blocks, splits the blocks into a binary tree, refines and collapses it, writes the records the kernels read.
#include "scene/bvh.h"

#include "base/error.h"
#include "base/parallel.h"
#include "scene/bvh_collapse.h"
#include "scene/bvh_refine.h"
#include "scene/bvh_split.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <string>
#include <thread>

namespace cmpg {
namespace {

static_assert(sizeof(gpu::BvhNode) == sizeof(BvhRecord) && sizeof(gpu::LeafBlock) == sizeof(BvhRecord));

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

struct Leaf {
    std::uint32_t record, begin, blocks, firstTriangle;
};

// Writes the records of the wide nodes and their leaves, depth first.
class Writer {
  public:
    Writer(const Geometry& geometry, const Collapse& collapse, const std::vector<Pair>& pairs, const std::vector<Reference>& references, Bvh& bvh)
        : geometry_(geometry), collapse_(collapse), pairs_(pairs), references_(references), bvh_(bvh) {
        const Box& box = collapse.root().box;
        const glm::vec3 reach = glm::max(glm::abs(box.low), glm::abs(box.high));
        // The triangle test rounds in units of the distance to the ray's origin; a ray accepted just outside a triangle must have
        // met its box. Eight units in the last place of the largest coordinate are more than those roundings together.
        padding_ = 8 * 6e-8f * std::max({reach.x, reach.y, reach.z});
        rootArea_ = std::max(box.halfArea(), std::numeric_limits<float>::min());
    }

    void run() {
        bvh_.records.emplace_back();
        if (!references_.empty())
            writeNode(0, collapse_.root(), 1);
        bvh_.sahCost = float(cost_);
        bvh_.order.resize(triangles_);
        parallelFor(leaves_.size(), 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                fillLeaf(leaves_[i]);
        });
    }

  private:
    void writeNode(std::uint32_t record, const Subtree& subtree, std::uint32_t depth) {
        std::array<Subtree, gpu::kBvhWidth> children;
        const std::uint32_t n = collapse_.children(subtree, children);
        bvh_.depth = std::max(bvh_.depth, depth);
        cost_ += subtree.box.halfArea() / rootArea_;

        gpu::BvhNode node{};
        node.base = std::uint32_t(bvh_.records.size());
        quantise(node, subtree.box, std::span(children.data(), n));
        std::uint32_t offset = 0;
        std::array<std::uint32_t, gpu::kBvhWidth> places;
        for (std::uint32_t c = 0; c < n; ++c) {
            const std::uint32_t blocks = children[c].leaf ? children[c].records() : 0;
            node.children |= (gpu::kChildExists | blocks << gpu::kChildBlocksShift | offset) << (8 * c);
            places[c] = node.base + offset;
            offset += children[c].records();
        }
        bvh_.records[record] = std::bit_cast<BvhRecord>(node);
        bvh_.records.resize(bvh_.records.size() + offset);
        for (std::uint32_t c = 0; c < n; ++c)
            if (children[c].leaf)
                placeLeaf(places[c], children[c]);
            else
                writeNode(places[c], children[c], depth + 1);
    }

    // Boxes on the node's grid, rounded outwards in double precision, where origin and steps are exact.
    void quantise(gpu::BvhNode& node, const Box& box, std::span<const Subtree> children) const {
        node.exponents = std::uint32_t(children.size()) << 24;
        for (int axis = 0; axis < 3; ++axis) {
            const float origin = box.low[axis] - padding_, top = box.high[axis] + padding_;
            int exponent = 0;
            std::frexp((double(top) - double(origin)) / 255, &exponent); // 255 * 2^exponent > extent
            exponent = std::clamp(exponent, -126, 127);
            const double step = std::ldexp(1.0, exponent);
            node.origin[axis] = origin;
            node.exponents |= std::uint32_t(exponent + 127) << (8 * axis);
            for (std::size_t c = 0; c < children.size(); ++c) {
                const double low = double(children[c].box.low[axis]) - padding_, high = double(children[c].box.high[axis]) + padding_;
                const auto place = [&](double plane) { return std::uint32_t(std::clamp(plane, 0.0, 255.0)) << (8 * c); };
                node.low[axis] |= place(std::floor((low - origin) / step));
                node.high[axis] |= place(std::ceil((high - origin) / step));
            }
        }
    }

    // Gives the leaf its place; its contents follow when all places are known.
    void placeLeaf(std::uint32_t record, const Subtree& leaf) {
        const std::uint32_t blocks = leaf.records();
        leaves_.push_back({record, leaf.begin, blocks, triangles_});
        for (std::uint32_t i = 0; i < blocks; ++i)
            triangles_ += references_[leaf.begin + i].triangles;
        bvh_.blocks += blocks;
        cost_ += double(leaf.box.halfArea() / rootArea_) * blocks;
    }

    void fillLeaf(const Leaf& leaf) {
        std::uint32_t first = leaf.firstTriangle;
        for (std::uint32_t i = 0; i < leaf.blocks; ++i) {
            const Reference& reference = references_[leaf.begin + i];
            bvh_.records[leaf.record + i] = std::bit_cast<BvhRecord>(block(pairs_[reference.item], first));
            first += reference.triangles;
        }
    }

    gpu::LeafBlock block(const Pair& pair, std::uint32_t first) {
        const Corners a = corners(geometry_, pair.a);
        gpu::LeafBlock block{};
        block.first = first;
        bvh_.order[first] = pair.a;
        SharedEdge edge;
        if (pair.b != kNoTriangle) {
            const Corners b = corners(geometry_, pair.b);
            edge = sharedEdge(a, b);
            block.v3 = b.p[(edge.turnB + (edge.flipB ? 1 : 2)) % 3];
            bvh_.order[first + 1] = pair.b;
        } else {
            block.v3 = a.p[2];
        }
        block.v0 = a.p[edge.turnA];
        block.v1 = a.p[(edge.turnA + 1) % 3];
        block.v2 = a.p[(edge.turnA + 2) % 3];
        block.turns = edge.turnA | (edge.turnB | (edge.flipB ? 4u : 0u)) << 4;
        return block;
    }

    const Geometry& geometry_;
    const Collapse& collapse_;
    const std::vector<Pair>& pairs_;
    const std::vector<Reference>& references_;
    Bvh& bvh_;
    float padding_, rootArea_;
    double cost_ = 0;
    std::vector<Leaf> leaves_;
    std::uint32_t triangles_ = 0; // in the leaves placed so far
};

} // namespace

Bvh buildBvh(const Geometry& geometry, unsigned threads) {
    std::vector<Pair> pairs;
    std::vector<Reference> references;
    pairTriangles(geometry, pairs, references);
    const SplitTree split = splitReferences(references, threads ? threads : std::max(1u, std::thread::hardware_concurrency()));

    Bvh bvh;
    bvh.records.reserve(references.size() * 3 / 2 + 1);
    Collapse collapse(split, references.size());
    // Refining looks at binary nodes; where that makes the wide ones no cheaper, as in scenes of a few boxes, it is dropped.
    RefinedTree refined = refine(split, references, gpu::kMaxBvhDepth);
    if (!refined.references.empty())
        if (Collapse other(refined.tree, refined.references.size()); other.cost() < collapse.cost()) {
            collapse = std::move(other);
            references = std::move(refined.references);
        }
    Writer(geometry, collapse, pairs, references, bvh).run();
    if (bvh.records.size() > gpu::kMaxBvhRecords)
        throw Error(ErrorKind::Input, "the scene has too many triangles: " + std::to_string(geometry.triangles.size()),
                    "the hierarchy over them exceeds what a kernel can address, 2 GiB", "simplify the scene; some 40 million triangles fit");
    return bvh;
}

} // namespace cmpg

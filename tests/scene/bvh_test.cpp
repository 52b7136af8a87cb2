// Invariants of the hierarchy, and that it does not depend on the number of threads.
#include "scene/bvh.h"
#include "scene/bvh_collapse.h"
#include "scene/bvh_refine.h"
#include "support/generated_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>

namespace cmpg {
namespace {

struct Bounds {
    glm::dvec3 low, high;
};

// Walks the records and checks that every triangle is in exactly one leaf and inside all boxes above it.
class Checker {
  public:
    Checker(const Geometry& g, const Bvh& bvh) : g_(g), bvh_(bvh), seen_(g.triangles.size()) {}

    void run() {
        const double huge = 1e30;
        node(0, {glm::dvec3(-huge), glm::dvec3(huge)}, 1);
        EXPECT_EQ(bvh_.order.size(), g_.triangles.size());
        EXPECT_EQ(std::count(seen_.begin(), seen_.end(), true), std::ptrdiff_t(seen_.size()));
        EXPECT_EQ(records_, bvh_.records.size()) << "records nobody refers to";
        EXPECT_EQ(blocks_, bvh_.blocks);
        EXPECT_EQ(depth_, bvh_.depth);
        EXPECT_LE(depth_, gpu::kMaxBvhDepth);
    }

  private:
    void node(std::uint32_t index, const Bounds& bounds, std::uint32_t depth) {
        ASSERT_LT(index, bvh_.records.size());
        ++records_;
        depth_ = std::max(depth_, depth);
        const auto node = std::bit_cast<gpu::BvhNode>(bvh_.records[index]);
        const std::uint32_t children = node.exponents >> 24;
        for (std::uint32_t c = 0; c < gpu::kBvhWidth; ++c) {
            const std::uint32_t child = node.children >> (8 * c) & 0xff;
            ASSERT_EQ(child != 0, c < children);
            if (child == 0)
                continue;
            Bounds box;
            for (int a = 0; a < 3; ++a) {
                const double step = std::ldexp(1.0, int(node.exponents >> (8 * a) & 0xff) - 127);
                box.low[a] = std::max(bounds.low[a], double(node.origin[a]) + step * (node.low[a] >> (8 * c) & 0xff));
                box.high[a] = std::min(bounds.high[a], double(node.origin[a]) + step * (node.high[a] >> (8 * c) & 0xff));
            }
            const std::uint32_t first = node.base + (child & gpu::kChildOffset);
            const std::uint32_t blocks = child >> gpu::kChildBlocksShift & gpu::kChildBlocks;
            ASSERT_LE(blocks, gpu::kMaxLeafBlocks);
            for (std::uint32_t b = 0; b < blocks; ++b)
                block(first + b, box);
            if (blocks == 0)
                this->node(first, box, depth + 1);
        }
    }

    void block(std::uint32_t index, const Bounds& box) {
        ASSERT_LT(index, bvh_.records.size());
        ++records_;
        ++blocks_;
        const auto block = std::bit_cast<gpu::LeafBlock>(bvh_.records[index]);
        triangle(block.first, {block.v0, block.v1, block.v2}, block.turns, box);
        if (block.v3 != block.v2)
            triangle(block.first + 1, {block.v0, block.v2, block.v3}, block.turns >> 4, box);
    }

    void triangle(std::uint32_t number, const std::array<glm::vec3, 3>& corners, std::uint32_t turns, const Bounds& box) {
        ASSERT_LT(number, bvh_.order.size());
        const std::uint32_t t = bvh_.order[number];
        ASSERT_FALSE(seen_[t]);
        seen_[t] = true;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t vertex = (turns & 4 ? (turns & 3) + 3 - i : (turns & 3) + i) % 3;
            const glm::vec3 p = g_.positions[g_.triangles[t].vertices[vertex]];
            ASSERT_EQ(corners[i], p);
            for (int a = 0; a < 3; ++a) {
                ASSERT_GT(double(p[a]), box.low[a]);
                ASSERT_LT(double(p[a]), box.high[a]);
            }
        }
    }

    const Geometry& g_;
    const Bvh& bvh_;
    std::vector<bool> seen_;
    std::size_t records_ = 0;
    std::uint32_t blocks_ = 0, depth_ = 0;
};

void check(const Geometry& g) { Checker(g, buildBvh(g)).run(); }

TEST(Bvh, HoldsEveryTriangleOnce) {
    check(generated::box());
    check(generated::room(0.5f));
    check(generated::soup(50'000, 0.05f, 1));
    check(generated::slivers(10'000, 2));
}

TEST(Bvh, Empty) {
    const Bvh bvh = buildBvh({});
    ASSERT_EQ(bvh.records.size(), 1u);
    EXPECT_EQ(std::bit_cast<gpu::BvhNode>(bvh.records[0]).children, 0u);
    EXPECT_TRUE(bvh.order.empty());
}

// Nothing separates equal triangles; the tree must still end.
TEST(Bvh, CoincidentTriangles) {
    Geometry g;
    for (int i = 0; i < 5000; ++i)
        generated::addTriangle(g, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    check(g);
}

// Sizes over thirty orders of magnitude drive the heuristic to split off one triangle at a time; the depth stays bounded.
TEST(Bvh, DepthIsBounded) {
    Geometry g;
    for (int i = 0; i < 3000; ++i) {
        const float s = std::pow(10.f, 15.f - 0.01f * float(i));
        generated::addTriangle(g, {s, 0, 0}, {s, s, 0}, {s, 0, s});
    }
    const Bvh bvh = buildBvh(g);
    EXPECT_LE(bvh.depth, gpu::kMaxBvhDepth);
    EXPECT_EQ(bvh.order.size(), g.triangles.size());
}

// Triangles that run around against their partner, and partners found through positions instead of indices.
TEST(Bvh, PairsTurnedTriangles) {
    const glm::vec3 p[4] = {{0, 0, 0}, {1, 0, 0.1f}, {1, 1, 0}, {0, 1, 0.2f}};
    for (int turnA = 0; turnA < 3; ++turnA)
        for (int turnB = 0; turnB < 3; ++turnB)
            for (bool flip : {false, true}) {
                const int a[3] = {0, 1, 2}, b[3] = {0, flip ? 3 : 2, flip ? 2 : 3};
                Geometry g;
                generated::addTriangle(g, p[a[turnA]], p[a[(turnA + 1) % 3]], p[a[(turnA + 2) % 3]]);
                generated::addTriangle(g, p[b[turnB]], p[b[(turnB + 1) % 3]], p[b[(turnB + 2) % 3]]);
                EXPECT_EQ(buildBvh(g).blocks, 1u);
                check(g);
            }
}

TEST(Bvh, DoesNotDependOnThreads) {
    const Geometry g = generated::soup(100'000, 0.03f, 3);
    const Bvh one = buildBvh(g, 1);
    for (unsigned threads : {2u, 3u, 8u}) {
        const Bvh other = buildBvh(g, threads);
        EXPECT_EQ(one.records, other.records) << threads << " threads";
        EXPECT_EQ(one.order, other.order) << threads << " threads";
    }
}

std::vector<Reference> boxesOf(const Geometry& g) {
    std::vector<Reference> references;
    for (std::uint32_t i = 0; i < g.triangles.size(); ++i) {
        Box box;
        for (const std::uint32_t v : g.triangles[i].vertices)
            box.grow(g.positions[v]);
        references.push_back({box.low, i, box.high, 1});
    }
    return references;
}

TEST(BvhRefine, MakesTheHierarchyOfARoomCheaperAndLosesNothing) {
    std::vector<Reference> references = boxesOf(generated::room(0.5f));
    const SplitTree tree = splitReferences(references, 1);
    const RefinedTree refined = refine(tree, references, gpu::kMaxBvhDepth);
    ASSERT_EQ(refined.references.size(), references.size());
    EXPECT_LT(Collapse(refined.tree, references.size()).cost(), 0.95f * Collapse(tree, references.size()).cost());
    std::vector<std::uint32_t> items;
    for (const Reference& r : refined.references)
        items.push_back(r.item);
    std::ranges::sort(items);
    for (std::uint32_t i = 0; i < items.size(); ++i)
        ASSERT_EQ(items[i], i);
}

TEST(BvhRefine, KeepsToTheDepth) {
    std::vector<Reference> references = boxesOf(generated::room(0.5f));
    EXPECT_TRUE(refine(splitReferences(references, 1), references, 0).references.empty()) << "longer than the longest path that was there";
}

// The least cost of a subtree as at most `most` children of one node, by trying everything.
float leastCost(const SplitTree& tree, const Subtree& t, std::uint32_t most) {
    const float area = t.box.halfArea();
    if (t.leaf)
        return area * float(t.records());
    const SplitNode& split = tree.slots[t.slot];
    const Subtree left{split.left, t.slot + 1, t.begin, split.middle, split.leftLeaf};
    const Subtree right{split.right, t.slot + (split.middle - t.begin), split.middle, t.end, split.rightLeaf};
    const auto halves = [&](std::uint32_t children) {
        float least = std::numeric_limits<float>::infinity();
        for (std::uint32_t i = 1; i < children; ++i)
            least = std::min(least, leastCost(tree, left, i) + leastCost(tree, right, children - i));
        return least;
    };
    const float whole = 1.5f * area + halves(gpu::kBvhWidth);
    return most == 1 ? whole : std::min(whole, halves(most));
}

TEST(BvhCollapse, IsTheCheapestOfAll) {
    for (std::uint32_t seed = 1; seed <= 20; ++seed) {
        std::vector<Reference> references = boxesOf(generated::soup(14, 0.4f, seed));
        const SplitTree tree = splitReferences(references, 1);
        const Collapse collapse(tree, references.size());
        EXPECT_FLOAT_EQ(collapse.cost(), leastCost(tree, collapse.root(), 1)) << "seed " << seed;
        // What it hands out costs what it says.
        const std::function<float(const Subtree&)> costOf = [&](const Subtree& node) {
            if (node.leaf)
                return node.box.halfArea() * float(node.records());
            std::array<Subtree, gpu::kBvhWidth> children;
            float sum = 1.5f * node.box.halfArea();
            for (std::uint32_t i = 0, n = collapse.children(node, children); i < n; ++i)
                sum += costOf(children[i]);
            return sum;
        };
        EXPECT_FLOAT_EQ(collapse.cost(), costOf(collapse.root())) << "seed " << seed;
    }
}

} // namespace
} // namespace cmpg

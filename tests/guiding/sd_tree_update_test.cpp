// Every step of an update against a second way to do it.
#include "guiding/field/quadtree.h"
#include "guiding/samples.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace cmpg {
namespace {

const glm::vec3 kLower(-1, -2, 0.5f), kUpper(1, 2, 1.5f);

struct Leaf {
    std::uint32_t depth = 0;
    double records = 0, reflected = 0;
    GuideMass mass;
};

// Top down, from the samples themselves: halve a box while too many lie in it; below the scout's depth positions are unknown and
// every half gets half of all.
void splitTopDown(const std::vector<Sample>& samples, glm::dvec3 lower, glm::dvec3 upper, std::uint32_t depth, double most, double share,
                  std::vector<Leaf>& leaves) {
    if (double(samples.size()) * share <= most) {
        Leaf leaf{depth, double(samples.size()) * share, 0, {}};
        for (const Sample& s : samples) {
            leaf.reflected += s.reflected * share;
            leaf.mass += s.mass * share;
        }
        leaves.push_back(leaf);
        return;
    }
    if (depth >= SdTree::kScoutDepth) {
        for (int half = 0; half < 2; ++half)
            splitTopDown(samples, lower, upper, depth + 1, most, share / 2, leaves);
        return;
    }
    const int axis = int(depth % 3);
    const double middle = (lower[axis] + upper[axis]) / 2;
    std::vector<Sample> below, above;
    for (const Sample& s : samples)
        (double(s.position[axis]) < middle ? below : above).push_back(s);
    glm::dvec3 end = upper, begin = lower;
    end[axis] = begin[axis] = middle;
    splitTopDown(below, lower, end, depth + 1, most, share, leaves);
    splitTopDown(above, begin, upper, depth + 1, most, share, leaves);
}

TEST(SdTreeUpdate, FirstUpdateEqualsATopDownSplit) {
    for (const std::uint32_t most : {10u, 60u, 1000u, 100'000u}) {
        SdTreeConfig config;
        config.cellRecords = most;
        config.maxNodes = 1u << 20;
        SdTree tree(kLower, kUpper, config);
        std::vector<Sample> samples = randomSamples(kLower, kUpper, 20'000, most);
        for (std::size_t i = 0; i < 3000; ++i)
            samples[i].position = {0.3f, 0.7f, 0.9f}; // a spot that is too much for any cell of the scout
        const UpdateReport report = tree.update(place(tree, samples));
        std::vector<Leaf> expected;
        splitTopDown(samples, kLower, kUpper, 0, most, 1, expected);

        std::vector<Leaf> found; // depth first, lower halves first
        const auto visit = [&](const auto& self, std::uint32_t node, std::uint32_t depth) -> void {
            const SpatialNode& n = tree.spatial()[node];
            if (!n.child) {
                const GuideCell& cell = tree.cells()[n.cell];
                found.push_back({depth, cell.records, cell.reflected, cell.total()});
                return;
            }
            self(self, n.child, depth + 1);
            self(self, n.child + 1, depth + 1);
        };
        visit(visit, 0, 0);
        ASSERT_EQ(found.size(), expected.size()) << most;
        for (std::size_t i = 0; i < found.size(); ++i) {
            EXPECT_EQ(found[i].depth, expected[i].depth);
            EXPECT_EQ(found[i].records, expected[i].records);
            EXPECT_EQ(found[i].reflected, expected[i].reflected);
            EXPECT_TRUE(same(found[i].mass, expected[i].mass)); // sums of dyadic values: exact in any order
        }
        EXPECT_EQ(report.refusedSplits, 0u);
        EXPECT_EQ(report.spatialSplits > 0, most < 3000);
    }
}

TEST(SdTreeUpdate, LaterUpdatesOnlySplit) {
    SdTreeConfig config;
    config.cellRecords = 500;
    SdTree tree(kLower, kUpper, config);
    tree.update(place(tree, randomSamples(kLower, kUpper, 20'000, 1)));
    const SdTree before = tree;
    const std::vector<CellRecords> records = place(tree, randomSamples(kLower, kUpper, 100'000, 2));
    const UpdateReport report = tree.update(records);
    std::uint32_t splits = 0;
    for (const CellRecords& r : records) {
        std::uint32_t parts = 1;
        while (double(r.count) / parts > config.cellRecords)
            parts *= 2;
        splits += parts - 1;
        EXPECT_EQ(tree.cells()[r.cell].records, (0.9 * before.cells()[r.cell].records + double(r.count)) / parts);
    }
    EXPECT_GT(splits, 0u);
    EXPECT_EQ(report.spatialSplits, splits);
    EXPECT_EQ(tree.cells().size(), before.cells().size() + splits);
}

// Masses of one cell's quadtree on the finest regular grid, leaves spread evenly.
constexpr std::uint32_t kFinest = 6; // levels below the square
constexpr std::uint32_t kEdge = 1u << kFinest;
using Grid = std::vector<GuideMass>;

void spread(const std::vector<QuadNode>& nodes, std::uint32_t node, std::uint32_t x, std::uint32_t y, std::uint32_t edge, Grid& grid) {
    edge /= 2;
    for (std::uint32_t q = 0; q < 4; ++q) {
        const std::uint32_t left = x + (q % 2) * edge, low = y + (q / 2) * edge;
        if (nodes[node].child[q]) {
            spread(nodes, nodes[node].child[q], left, low, edge, grid);
            continue;
        }
        for (std::uint32_t v = low; v < low + edge; ++v)
            for (std::uint32_t u = left; u < left + edge; ++u)
                grid[v * kEdge + u] = nodes[node].mass[q] * (1.0 / (edge * edge));
    }
}

GuideMass area(const Grid& grid, std::uint32_t x, std::uint32_t y, std::uint32_t edge) {
    GuideMass sum;
    for (std::uint32_t v = y; v < y + edge; ++v)
        for (std::uint32_t u = x; u < x + edge; ++u)
            sum += grid[v * kEdge + u];
    return sum;
}

// Compares a refined tree with what the grid of the old one asks for. Returns the number of nodes it should have.
std::uint32_t compare(const std::vector<QuadNode>& nodes, std::uint32_t node, const Grid& grid, const GuideMass& all, double share,
                      std::uint32_t x, std::uint32_t y, std::uint32_t edge) {
    std::uint32_t count = 1;
    edge /= 2;
    for (std::uint32_t q = 0; q < 4; ++q) {
        const std::uint32_t left = x + (q % 2) * edge, low = y + (q / 2) * edge;
        const GuideMass m = area(grid, left, low, edge);
        EXPECT_TRUE(same(nodes[node].mass[q], m)) << "quadrant " << q << " of " << edge << " at " << left << ", " << low;
        const bool inner = edge > 1 && (m.primal > share * all.primal || m.plus > share * all.plus || m.minus > share * all.minus);
        EXPECT_EQ(nodes[node].child[q] != 0, inner) << "quadrant " << q << " of " << edge << " at " << left << ", " << low;
        if (inner && nodes[node].child[q])
            count += compare(nodes, nodes[node].child[q], grid, all, share, left, low, edge);
    }
    return count;
}

TEST(QuadtreeRefinement, EqualsTheOneOnARegularGrid) {
    const QuadRefinement rule{0.01, kFinest};
    for (std::uint32_t seed = 0; seed < 50; ++seed) {
        // An arbitrary old tree with arbitrary dyadic masses, concentrated or not.
        std::mt19937 random(seed);
        std::vector<QuadNode> old(1);
        std::vector<std::uint32_t> depth = {1};
        for (std::uint32_t i = 0; i < old.size(); ++i)
            for (std::uint32_t q = 0; q < 4; ++q) {
                const double scale = random() % 8 ? 1 : 4096;
                old[i].mass[q] = {scale * (random() % 256), random() % 3 ? 0 : scale * (random() % 256), seed % 2 ? 0.0 : random() % 256};
                if (depth[i] < kFinest && random() % 3 == 0) {
                    old[i].child[q] = std::uint32_t(old.size());
                    depth.push_back(depth[i] + 1);
                    old.emplace_back();
                }
            }
        sumUp(old);
        Grid grid(kEdge * kEdge);
        spread(old, 0, 0, 0, kEdge, grid);
        const std::vector<QuadNode> now = refined(old, rule, 1u << 20);
        EXPECT_EQ(validateQuadtree(now, kFinest), "");
        const std::uint32_t count = compare(now, 0, grid, area(grid, 0, 0, kEdge), rule.share, 0, 0, kEdge);
        EXPECT_EQ(now.size(), count);

        const QuadDemand needs = demand(old, rule);
        EXPECT_EQ(needs.wanted, now.size());
        EXPECT_LE(needs.kept, std::min(needs.wanted, std::uint64_t(old.size())));
        // What fits into fewer nodes is the coarse part of it: the same nodes, without the last.
        const std::size_t some = 1 + now.size() / 2;
        const std::vector<QuadNode> fewer = refined(old, rule, some);
        ASSERT_EQ(fewer.size(), some);
        EXPECT_EQ(validateQuadtree(fewer, kFinest), "");
        EXPECT_TRUE(same(total(fewer[0]), total(old[0])));
        for (std::size_t i = 0; i < some; ++i)
            for (std::uint32_t q = 0; q < 4; ++q)
                EXPECT_TRUE(same(fewer[i].mass[q], now[i].mass[q]));
    }
}

TEST(QuadtreeRefinement, LeavesAlone) {
    // Nothing known: one node. Everything in one leaf: a path of nodes down to it.
    std::vector<QuadNode> nodes = regularQuadtree(3);
    EXPECT_EQ(nodes.size(), 21u);
    EXPECT_EQ(refined(nodes, {0.01, 10}, 1000).size(), 1u);
    nodes[20].mass[3].minus = 5;
    sumUp(nodes);
    const std::vector<QuadNode> path = refined(nodes, {0.3, 3}, 1000);
    EXPECT_EQ(path.size(), 3u);
    EXPECT_EQ(path[2].mass[3].minus, 5);
    // Shares of a new quarter: 1, 1/4, 1/16 of all, so a share of 0.1 asks for two levels more.
    EXPECT_EQ(refined(nodes, {0.1, 10}, 1000).size(), 3u + 1 + 4);
}

TEST(SdTreeUpdate, ReportsWhatTheNodeLimitRefuses) {
    const std::vector<Sample> samples = randomSamples(kLower, kUpper, 50'000, 7);
    SdTreeConfig config;
    config.cellRecords = 100'000; // one cell
    config.directionShare = 0.003;
    SdTree free(kLower, kUpper, config);
    EXPECT_EQ(free.update(place(free, samples)).refusedSplits, 0u);
    ASSERT_EQ(free.cells().size(), 1u);
    const std::uint64_t wanted = free.nodes();
    ASSERT_GT(wanted, 50u);

    // The scout is one cell of 21 nodes, so it wants the same.
    config.maxNodes = 40;
    SdTree tight(kLower, kUpper, config);
    const UpdateReport report = tight.update(place(tight, samples));
    EXPECT_EQ(tight.nodes(), 40u);
    EXPECT_EQ(report.refusedSplits, wanted - 40);

    // Cells: each has one node at least, so no more than the limit; the rest is refused and reported.
    config.cellRecords = 50;
    config.directionShare = 2; // no quadrant ever
    config.maxNodes = 100;
    SdTree cells(kLower, kUpper, config);
    UpdateReport last;
    for (std::uint32_t i = 0; i < 4; ++i)
        last = cells.update(place(cells, samples));
    EXPECT_EQ(cells.nodes(), 100u);
    EXPECT_EQ(cells.cells().size(), 100u);
    EXPECT_GT(last.refusedSplits, 0u);
}

} // namespace
} // namespace cmpg

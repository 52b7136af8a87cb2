// The guide's tree as a whole: what must hold after any updates.
#include "guiding/samples.h"

#include "base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <sched.h>

namespace cmpg {
namespace {

// Extents are powers of two, so that middles and scaled positions are exact.
const glm::vec3 kLower(-1, -2, 0.5f), kUpper(1, 2, 1.5f);

SdTreeConfig smallConfig() {
    SdTreeConfig config;
    config.cellRecords = 200;
    config.maxQuadDepth = 7;
    return config;
}

// Runs all threads on one processor, hence in another order, as long as it lives.
class OneProcessor {
  public:
    OneProcessor() {
        sched_getaffinity(0, sizeof before_, &before_);
        cpu_set_t one;
        CPU_ZERO(&one);
        for (int i = 0; i < CPU_SETSIZE; ++i)
            if (CPU_ISSET(i, &before_)) {
                CPU_SET(i, &one);
                break;
            }
        sched_setaffinity(0, sizeof one, &one);
    }
    ~OneProcessor() { sched_setaffinity(0, sizeof before_, &before_); }

  private:
    cpu_set_t before_;
};

TEST(SdTree, KnowsNothingAtFirst) {
    SdTree tree(kLower, kUpper, {});
    EXPECT_EQ(tree.validate(), "");
    EXPECT_TRUE(tree.empty());
    EXPECT_EQ(tree.cells().size(), 1u << SdTree::kScoutDepth);
    EXPECT_EQ(tree.nodes(), 21u << SdTree::kScoutDepth);
    EXPECT_EQ(totals(tree).mass.primal, 0);
    // Nothing learnt: still a tree that knows nothing.
    tree.update({});
    EXPECT_TRUE(tree.empty());
    EXPECT_EQ(tree.cells().size(), 1u << SdTree::kScoutDepth);
}

TEST(SdTree, ScoutsWithinTheNodeLimit) {
    for (const std::uint64_t limit : {0u, 1u, 4u, 5u, 20u, 21u, 42u, 1000u, 86015u, 86016u, 1u << 18}) {
        SdTreeConfig config;
        config.maxNodes = limit;
        const SdTree tree(kLower, kUpper, config);
        EXPECT_EQ(tree.validate(), "") << limit;
        EXPECT_LE(tree.nodes(), std::max<std::uint64_t>(limit, 1));
        EXPECT_GT(2 * std::min<std::uint64_t>(tree.nodes() + 21, 86016), std::min<std::uint64_t>(limit, 86016)) << "less than half is used";
    }
}

TEST(SdTree, HoldsTogetherOverAHundredUpdates) {
    SdTreeConfig config = smallConfig();
    config.maxNodes = 20'000;
    SdTree tree(kLower, kUpper, config);
    std::uint64_t refused = 0;
    for (std::uint32_t i = 0; i < 100; ++i) {
        // Every tenth pass sees a corner of the box only.
        const glm::vec3 upper = i % 10 == 9 ? kLower + (kUpper - kLower) * 0.05f : kUpper;
        const UpdateReport report = tree.update(place(tree, randomSamples(kLower, upper, 5000, i)));
        EXPECT_EQ(report.records, 5000u);
        refused += report.refusedSplits;
        ASSERT_EQ(tree.validate(), "") << "after update " << i;
        ASSERT_LE(tree.nodes(), config.maxNodes);
    }
    EXPECT_EQ(tree.updates(), 100u);
    EXPECT_GT(refused, 0u) << "the limit was to be reached";
}

TEST(SdTree, ConservesMass) {
    SdTree tree(kLower, kUpper, smallConfig());
    for (std::uint32_t i = 0; i < 30; ++i) {
        const TreeTotals before = totals(tree);
        TreeTotals added;
        const std::vector<Sample> samples = randomSamples(kLower, kUpper, 5000, i);
        for (const Sample& s : samples) {
            added.mass += s.mass;
            added.reflected += s.reflected;
            added.derivative += s.derivative;
        }
        tree.update(place(tree, samples));
        const TreeTotals after = totals(tree);
        // Sums of at most 1e6 non-negative doubles, in other orders: rounding stays below 1e6 * 1.1e-16.
        const auto expectSum = [&](double now, double old, double more) {
            const double truth = 0.9 * old + more;
            EXPECT_NEAR(now, truth, 1e-10 * truth) << "update " << i;
        };
        expectSum(after.mass.primal, before.mass.primal, added.mass.primal);
        expectSum(after.mass.plus, before.mass.plus, added.mass.plus);
        expectSum(after.mass.minus, before.mass.minus, added.mass.minus);
        expectSum(after.records, before.records, double(samples.size()));
        expectSum(after.reflected, before.reflected, added.reflected);
        expectSum(after.derivative, before.derivative, added.derivative);
    }
}

TEST(SdTree, DependsNeitherOnSchedulingNorOnTheOrderOfRecords) {
    const auto grow = [](bool shuffled) {
        SdTreeConfig config = smallConfig();
        config.maxNodes = 30'000;
        SdTree tree(kLower, kUpper, config);
        for (std::uint32_t i = 0; i < 12; ++i) {
            std::vector<CellRecords> records = place(tree, randomSamples(kLower, kUpper, 20'000, i));
            if (shuffled)
                std::shuffle(records.begin(), records.end(), std::mt19937(i));
            tree.update(records);
        }
        return tree;
    };
    const SdTree many = grow(false);
    EXPECT_TRUE(same(many, grow(true)));
    const OneProcessor one;
    EXPECT_TRUE(same(many, grow(false)));
}

TEST(SdTree, LeavesTheMeansOfUntouchedCellsAlone) {
    SdTree tree(kLower, kUpper, smallConfig());
    tree.update(place(tree, randomSamples(kLower, kUpper, 20'000, 1)));
    for (GuideCell& cell : tree.cells())
        cell.changed = false;
    const SdTree before = tree;
    const glm::vec3 part = kLower + (kUpper - kLower) * 0.3f;
    const std::vector<CellRecords> records = place(tree, randomSamples(kLower, part, 2000, 2));
    tree.update(records);
    std::size_t untouched = 0;
    for (std::size_t i = 0; i < before.cells().size(); ++i) {
        const bool touched = std::any_of(records.begin(), records.end(), [&](const CellRecords& r) { return r.cell == i; });
        const GuideCell &now = tree.cells()[i], &old = before.cells()[i];
        EXPECT_EQ(now.changed, touched);
        if (touched)
            continue;
        ++untouched;
        EXPECT_EQ(now.nodes.size(), old.nodes.size());
        // A product and a division each round once, sums over four levels a few times more.
        EXPECT_NEAR(now.total().primal * old.records, old.total().primal * now.records, 1e-14 * old.total().primal * now.records);
    }
    EXPECT_GT(untouched, before.cells().size() / 4);
    for (std::size_t i = before.cells().size(); i < tree.cells().size(); ++i)
        EXPECT_TRUE(tree.cells()[i].changed);
}

// Learning passes, between which nothing changes.
TEST(SdTree, KeepsAllWhereNothingChanged) {
    SdTree tree(kLower, kUpper, smallConfig());
    const std::vector<CellRecords> first = place(tree, randomSamples(kLower, kUpper, 20'000, 1));
    tree.update(first, false);
    const TreeTotals before = totals(tree);
    const std::vector<CellRecords> second = place(tree, randomSamples(kLower, kUpper, 2000, 2));
    tree.update(second, false);
    EXPECT_EQ(tree.validate(), "");
    EXPECT_EQ(before.records, 20'000);
    EXPECT_NEAR(totals(tree).records, 22'000, 1e-9);
    EXPECT_GT(totals(tree).mass.primal, before.mass.primal);
    tree.update({});
    EXPECT_NEAR(totals(tree).records, 0.9 * 22'000, 1e-8);
}

TEST(SdTree, ForgetsAltogether) {
    SdTreeConfig config = smallConfig();
    config.forgetting = 0;
    SdTree tree(kLower, kUpper, config);
    tree.update(place(tree, randomSamples(kLower, kUpper, 20'000, 1)));
    for (GuideCell& cell : tree.cells())
        cell.changed = false;
    const std::vector<CellRecords> one(1, place(tree, randomSamples(kLower, kUpper, 2000, 2))[0]);
    tree.update(one);
    EXPECT_EQ(tree.validate(), "");
    EXPECT_EQ(totals(tree).records, double(one[0].count));
    for (const GuideCell& cell : tree.cells())
        EXPECT_TRUE(cell.changed);
}

TEST(SdTree, ForgetsBelowDenormalWeights) {
    SdTreeConfig config = smallConfig();
    config.forgetting = 1e-30;
    SdTree tree(kLower, kUpper, config);
    tree.update(place(tree, randomSamples(kLower, kUpper, 2000, 1)));
    for (std::uint32_t i = 0; i < 15; ++i) {
        tree.update({});
        ASSERT_EQ(tree.validate(), "") << "after " << i;
    }
    EXPECT_EQ(totals(tree).records, 0);
    EXPECT_EQ(totals(tree).mass.primal, 0);
}

TEST(SdTree, FindsCellsByTheirMiddle) {
    SdTree tree(kLower, kUpper, smallConfig());
    for (std::uint32_t i = 0; i < 3; ++i)
        tree.update(place(tree, randomSamples(kLower, kUpper, 20'000, i)));
    std::size_t found = 0;
    const auto visit = [&](const auto& self, std::uint32_t node, glm::dvec3 lower, glm::dvec3 upper, int axis) -> void {
        const SpatialNode& n = tree.spatial()[node];
        const glm::dvec3 middle = (lower + upper) * 0.5;
        if (!n.child) {
            EXPECT_EQ(tree.cellAt(middle), n.cell);
            EXPECT_EQ(tree.cellAt(lower), n.cell) << "lower faces belong to a cell";
            ++found;
            return;
        }
        glm::dvec3 end = upper, begin = lower;
        end[axis] = begin[axis] = middle[axis];
        self(self, n.child, lower, end, (axis + 1) % 3);
        self(self, n.child + 1, begin, upper, (axis + 1) % 3);
    };
    visit(visit, 0, kLower, kUpper, 0);
    EXPECT_EQ(found, tree.cells().size());
    // Outside counts as on the faces.
    EXPECT_EQ(tree.cellAt({-9, 0.3f, 0.9f}), tree.cellAt({-1, 0.3f, 0.9f}));
    EXPECT_EQ(tree.cellAt({9, 9, 9}), tree.cellAt(kUpper));
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(tree.cellAt({inf, -inf, 1}), tree.cellAt({1, -2, 1}));
    EXPECT_EQ(tree.cellAt({nan, nan, nan}), tree.cellAt(kLower));
}

TEST(SdTree, TakesFlatAndEmptyBoxes) {
    const float inf = std::numeric_limits<float>::infinity();
    const std::pair<glm::vec3, glm::vec3> boxes[] = {
        {{0, 0, 1}, {1, 1, 1}}, {{2, 2, 2}, {2, 2, 2}}, {{inf, inf, inf}, {-inf, -inf, -inf}}, {{0, 0, 0}, {1e-45f, 3e38f, 1}}};
    for (const auto& [lower, upper] : boxes) {
        SdTree tree(lower, upper, smallConfig());
        ASSERT_EQ(tree.validate(), "");
        for (std::uint32_t i = 0; i < 5; ++i) {
            tree.update(place(tree, randomSamples(tree.lower(), tree.upper(), 5000, i)));
            ASSERT_EQ(tree.validate(), "");
        }
    }
}

TEST(SdTree, CountsWhatIsNoSumAsNothing) {
    SdTree tree(kLower, kUpper, smallConfig());
    std::vector<CellRecords> records = place(tree, randomSamples(kLower, kUpper, 5000, 1));
    const double odd[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1, 1e40};
    for (std::size_t i = 0; i < records.size(); ++i) {
        CellRecords& r = records[i];
        r.reflected = odd[i % 4];
        r.derivative = odd[(i + 1) % 4];
        for (auto& leaf : r.leaves)
            leaf[i % 4] = {odd[i % 4], odd[(i + 1) % 4], odd[(i + 2) % 4]};
    }
    tree.update(records);
    EXPECT_EQ(tree.validate(), "");
    EXPECT_EQ(totals(tree).reflected, 0);
    EXPECT_GT(totals(tree).mass.primal, 0);
}

TEST(SdTree, RefusesRecordsOfAnotherState) {
    SdTree tree(kLower, kUpper, smallConfig());
    const std::vector<CellRecords> records = place(tree, randomSamples(kLower, kUpper, 5000, 1));
    std::vector<CellRecords> twice = records;
    twice.push_back(records[0]);
    EXPECT_THROW(tree.update(twice), Error);
    std::vector<CellRecords> outside = records;
    outside[0].cell = std::uint32_t(tree.cells().size());
    EXPECT_THROW(tree.update(outside), Error);
    tree.update(records);
    EXPECT_THROW(tree.update(records), Error);
}

} // namespace
} // namespace cmpg

// Sums over ranks, which are threads here.
#include "base/communicator.h"

#include "library/ranks.h"
#include "support/environment.h"
#include "support/processors.h"
#include "support/thread_ranks.h"

#include <cstdlib>
#include <random>
#include <thread>

namespace cmpg {
namespace {

using test::ThreadRank;

// Ranks of one machine, of which this process is the first, and the others may use the processors that it may, or others.
class Neighbours final : public Communicator {
  public:
    Neighbours(int ranks, int alike) : ranks_(ranks), alike_(alike) {}
    int rank() const override { return 0; }
    int size() const override { return ranks_; }
    int localRank() const override { return 0; }
    int localSize() const override { return ranks_; }
    void sum(std::span<std::int64_t>) override {}
    void broadcast(std::span<std::byte>, int) override {}
    void gatherInto(std::span<const std::byte> own, std::span<const std::size_t>, std::span<std::byte> all) override {
        for (int r = 0; r < ranks_; ++r) {
            const auto at = std::copy(own.begin(), own.end(), all.begin() + std::ptrdiff_t(std::size_t(r) * own.size()));
            if (r >= alike_)
                at[-1] ^= std::byte{0x80}; // the last processor there may be
        }
    }

  private:
    int ranks_, alike_;
};

TEST(Communicator, RanksDivideTheProcessorsThatTheyShare) {
    const test::Environment restored("LP_NUM_THREADS", nullptr); // whatever is set below
    const auto threads = [](int ranks, int alike) {
        unsetenv("LP_NUM_THREADS");
        Neighbours neighbours(ranks, alike);
        v1::divideProcessors(neighbours);
        const char* const found = std::getenv("LP_NUM_THREADS");
        return found ? std::atoi(found) : 0;
    };
    const int count = test::processorsAllowed();
    EXPECT_EQ(threads(1, 1), 0);
    EXPECT_EQ(threads(2, 2), std::max(1, count / 2));
    EXPECT_EQ(threads(4, 2), std::max(1, count / 2)); // two each in two sets
    EXPECT_EQ(threads(4, 1), count);
    EXPECT_EQ(threads(64, 64), std::max(1, count / 64));
    {
        const test::OneProcessor fewer;
        EXPECT_EQ(threads(2, 2), 1);
        EXPECT_EQ(threads(2, 1), 1);
    }
    setenv("LP_NUM_THREADS", "3", 1);
    Neighbours neighbours(2, 2);
    v1::divideProcessors(neighbours);
    EXPECT_STREQ(std::getenv("LP_NUM_THREADS"), "3"); // who sets it knows better
}

TEST(Communicator, SparseSumsAreSums) {
    constexpr int kRanks = 3;
    constexpr std::size_t kEntries = 300000; // blocks of all kinds: empty, with few entries, full
    std::vector<std::vector<std::int64_t>> values(kRanks, std::vector<std::int64_t>(kEntries));
    std::vector<std::int64_t> expected(kEntries);
    std::mt19937_64 random(7);
    for (auto& own : values)
        for (std::size_t i = 0; i < kEntries; ++i)
            if (i < 70000 || (i > 200000 && random() % 100 == 0))
                own[i] = std::int64_t(random()); // their sums overflow
    for (const auto& own : values)
        for (std::size_t i = 0; i < kEntries; ++i)
            expected[i] = std::int64_t(std::uint64_t(expected[i]) + std::uint64_t(own[i]));
    ThreadRank::Table table(kRanks);
    std::vector<std::size_t> dense(kRanks);
    {
        std::vector<std::jthread> threads;
        for (int r = 0; r < kRanks; ++r)
            threads.emplace_back([&, r] {
                ThreadRank rank(table, r);
                sumSparse(rank, values[std::size_t(r)]);
                dense[std::size_t(r)] = rank.dense;
            });
    }
    for (int r = 0; r < kRanks; ++r) {
        EXPECT_EQ(values[std::size_t(r)], expected);
        EXPECT_GT(dense[std::size_t(r)], 65536u);  // the full block
        EXPECT_LT(dense[std::size_t(r)], 150000u); // and not those with few entries
    }
}

TEST(Communicator, OneRankKeepsWhatItHas) {
    std::vector<std::int64_t> values = {1, -2, 3};
    sumSparse(oneRank(), values);
    EXPECT_EQ(values, (std::vector<std::int64_t>{1, -2, 3}));
    EXPECT_TRUE(ranks().isRoot());
    EXPECT_EQ(ranks().size(), 1);
}

} // namespace
} // namespace cmpg

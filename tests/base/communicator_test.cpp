// Sums over ranks, which are threads here.
#include "base/communicator.h"

#include "support/thread_ranks.h"

#include <random>
#include <thread>

namespace cmpg {
namespace {

using test::ThreadRank;

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

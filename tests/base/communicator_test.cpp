// Sums over ranks, which are threads here.
#include "base/communicator.h"

#include <barrier>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <thread>

namespace cmpg {
namespace {

// What the threads hand to each other.
struct Table {
    explicit Table(int ranks) : meet(ranks), spans(std::size_t(ranks)) {}
    std::barrier<> meet;
    std::vector<std::span<const std::byte>> spans;
};

class ThreadRank final : public Communicator {
  public:
    ThreadRank(Table& table, int rank) : table_(table), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return int(table_.spans.size()); }
    int localRank() const override { return rank_; }
    int localSize() const override { return size(); }
    void sum(std::span<std::int64_t> values) override {
        dense += values.size();
        std::vector<std::int64_t> total(values.size());
        exchange(std::as_bytes(values), [&](std::span<const std::byte> bytes) {
            for (std::size_t i = 0; i < total.size(); ++i)
                total[i] = std::int64_t(std::uint64_t(total[i]) + std::uint64_t(reinterpret_cast<const std::int64_t*>(bytes.data())[i]));
        });
        std::copy(total.begin(), total.end(), values.begin());
    }
    void broadcast(std::span<std::byte>, int) override { FAIL(); }
    void gatherInto(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) override {
        EXPECT_EQ(own.size(), sizes[std::size_t(rank_)]);
        auto at = all.begin();
        exchange(own, [&](std::span<const std::byte> bytes) { at = std::copy(bytes.begin(), bytes.end(), at); });
        EXPECT_EQ(at, all.end());
    }
    Traffic traffic() const override { return {}; }
    std::size_t dense = 0; // entries of sums

  private:
    void exchange(std::span<const std::byte> own, const std::function<void(std::span<const std::byte>)>& take) {
        table_.spans[std::size_t(rank_)] = own;
        table_.meet.arrive_and_wait();
        for (const auto& span : table_.spans)
            take(span);
        table_.meet.arrive_and_wait();
    }
    Table& table_;
    int rank_;
};

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
    Table table(kRanks);
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

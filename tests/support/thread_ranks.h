// Ranks that are threads of one process.
#pragma once

#include <cmpg/communicator.h>

#include <algorithm>
#include <barrier>
#include <functional>
#include <gtest/gtest.h>

namespace cmpg::test {

class ThreadRank final : public Communicator {
  public:
    // What the threads hand to each other.
    struct Table {
        explicit Table(int ranks) : meet(ranks), spans(std::size_t(ranks)) {}
        std::barrier<> meet;
        std::vector<std::span<const std::byte>> spans;
    };

    ThreadRank(Table& table, int rank) : table_(table), rank_(rank) {}
    int rank() const override { return rank_; }
    int size() const override { return int(table_.spans.size()); }
    int localRank() const override { return 0; } // none divides the processors
    int localSize() const override { return 1; }
    void sum(std::span<std::int64_t> values) override {
        dense += values.size();
        std::vector<std::int64_t> total(values.size());
        exchange(std::as_bytes(values), [&](std::span<const std::byte> bytes) {
            for (std::size_t i = 0; i < total.size(); ++i)
                total[i] = std::int64_t(std::uint64_t(total[i]) + std::uint64_t(reinterpret_cast<const std::int64_t*>(bytes.data())[i]));
        });
        std::copy(total.begin(), total.end(), values.begin());
    }
    void broadcast(std::span<std::byte> bytes, int root) override {
        const std::vector<std::byte> own(bytes.begin(), bytes.end());
        int from = 0;
        exchange(own, [&](std::span<const std::byte> found) {
            if (from++ == root)
                std::copy(found.begin(), found.end(), bytes.begin());
        });
    }
    void gatherInto(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) override {
        EXPECT_EQ(own.size(), sizes[std::size_t(rank_)]);
        auto at = all.begin();
        exchange(own, [&](std::span<const std::byte> bytes) { at = std::copy(bytes.begin(), bytes.end(), at); });
        EXPECT_EQ(at, all.end());
    }
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

} // namespace cmpg::test

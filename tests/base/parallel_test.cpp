// The host's thread helper: every index once, ranges that do not depend on the machine, errors that come back.
#include "base/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace cmpg {
namespace {

TEST(ParallelFor, RangesCoverEveryIndexOnce) {
    for (const std::size_t count : {0u, 1u, 7u, 64u, 65u, 100'000u})
        for (const std::size_t grain : {0u, 1u, 64u, 1'000'000u}) {
            std::mutex mutex;
            std::set<std::pair<std::size_t, std::size_t>> ranges;
            parallelFor(count, grain, [&](std::size_t begin, std::size_t end) {
                const std::lock_guard lock(mutex);
                EXPECT_TRUE(ranges.emplace(begin, end).second);
            });
            std::size_t next = 0;
            for (const auto& [begin, end] : ranges) {
                EXPECT_EQ(begin, next);
                EXPECT_EQ(end, std::min(count, begin + std::max<std::size_t>(grain, 1)));
                next = end;
            }
            EXPECT_EQ(next, count);
        }
}

TEST(ParallelFor, RethrowsTheFirstRangesError) {
    for (int repeat = 0; repeat < 100; ++repeat) {
        std::string message;
        try {
            parallelFor(1000, 10, [](std::size_t begin, std::size_t) {
                if (begin >= 50)
                    throw std::runtime_error(std::to_string(begin));
            });
        } catch (const std::runtime_error& error) {
            message = error.what();
        }
        EXPECT_EQ(message, "50");
    }
}

// Helpers are shared: calls from several threads, and calls within calls, neither wait for each other's helpers nor mix their ranges.
TEST(ParallelFor, CallsWithinCallsFromSeveralThreads) {
    constexpr std::size_t kCallers = 6, kOuter = 40, kInner = 100;
    std::vector<std::atomic<int>> seen(kCallers * kOuter * kInner);
    {
        std::vector<std::jthread> callers;
        for (std::size_t caller = 0; caller < kCallers; ++caller)
            callers.emplace_back([&, caller] {
                parallelFor(kOuter, 1, [&](std::size_t outer, std::size_t) {
                    parallelFor(kInner, 7, [&](std::size_t begin, std::size_t end) {
                        for (std::size_t i = begin; i < end; ++i)
                            ++seen[(caller * kOuter + outer) * kInner + i];
                    });
                });
            });
    }
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](const std::atomic<int>& times) { return times == 1; }));
}

TEST(ParallelFor, ManyShortCallsInARow) {
    for (std::size_t repeat = 0; repeat < 20'000; ++repeat) {
        std::atomic<std::size_t> sum = 0;
        parallelFor(8, 1, [&](std::size_t begin, std::size_t) { sum += begin; });
        ASSERT_EQ(sum, 28u);
    }
}

TEST(ParallelFor, GrainOfTheWholeRange) {
    std::atomic<int> calls = 0;
    parallelFor(5, std::numeric_limits<std::size_t>::max(), [&](std::size_t begin, std::size_t end) {
        ++calls;
        EXPECT_EQ(end - begin, 5u);
    });
    EXPECT_EQ(calls, 1);
}

} // namespace
} // namespace cmpg

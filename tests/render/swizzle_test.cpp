// The order of workgroups on CPU drivers, compiled from the shaders' own source.
#include "shared/swizzle.h"
#include "shared/wavefront.h"

#include <gtest/gtest.h>
#include <vector>

namespace cmpg {
namespace {

TEST(Swizzle, IsAPermutation) {
    for (gpu::uint threads : {1u, 2u, 3u, 8u, 64u})
        for (gpu::uint groups = 1; groups <= 1000; ++groups) {
            std::vector<bool> seen(groups);
            for (gpu::uint g = 0; g < groups; ++g) {
                const gpu::uint place = gpu::swizzleGroup(g, groups, threads);
                ASSERT_LT(place, groups);
                ASSERT_FALSE(seen[place]) << groups << " groups, " << threads << " threads";
                seen[place] = true;
            }
        }
}

TEST(Swizzle, ThreadsWalkSideBySide) {
    // Two threads run groups [0, 50) and [50, 100): at every moment their work is neighbouring.
    for (gpu::uint g = 0; g < 50; ++g)
        EXPECT_EQ(gpu::swizzleGroup(g, 100, 2) + 1, gpu::swizzleGroup(50 + g, 100, 2));
}

TEST(Swizzle, OneThreadKeepsTheOrder) {
    for (gpu::uint g = 0; g < 100; ++g)
        EXPECT_EQ(gpu::swizzleGroup(g, 100, 1), g);
}

// By the invocation's number alone, so the subgroups may have any size.
TEST(Chunk, EveryItemIsTakenOnce) {
    std::vector<int> taken(gpu::kTraceChunk, 0);
    for (gpu::uint invocation = 0; invocation < gpu::kVertexGroup; ++invocation)
        for (gpu::uint round = 0; round < gpu::kChunkRounds; ++round) {
            const gpu::uint item = gpu::chunkItem(invocation, round);
            ASSERT_LT(item, gpu::kTraceChunk);
            ++taken[item];
            EXPECT_EQ(item, gpu::chunkItem(invocation, 0) + round * gpu::kChunkRun); // as the kernels step
        }
    EXPECT_EQ(taken, std::vector<int>(gpu::kTraceChunk, 1));
}

} // namespace
} // namespace cmpg

// Which workgroup does which part of the work on a CPU driver that hands every thread one contiguous range of workgroups.
#ifndef CMPG_SHARED_SWIZZLE
#define CMPG_SHARED_SWIZZLE
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

// A permutation of 0 .. groups - 1: threads that run groups [t n/T, (t+1) n/T) side by side then do neighbouring work and share
// caches. threads = 1 (a GPU): the identity. The groups left over by n/T stay where they are.
#ifdef __cplusplus
constexpr
#endif
uint swizzleGroup(uint group, uint groups, uint threads) {
    const uint each = groups / threads;
    return group < each * threads ? (group % each) * threads + group / each : group;
}

// Which of a chunk's 256 items an invocation takes in a round: neighbours side by side, eight to a run, as many as a vector of CPU drivers has. By the
// number in the workgroup alone: it holds for any size of subgroup, wider than the workgroup too.
CMPG_CONST kChunkRounds = 4;
CMPG_CONST kChunkRun = 8;
#ifdef __cplusplus
constexpr
#endif
uint chunkItem(uint invocation, uint round) {
    return (invocation / kChunkRun * kChunkRounds + round) * kChunkRun + invocation % kChunkRun;
}

CMPG_SHARED_END
#endif

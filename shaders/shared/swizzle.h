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

CMPG_SHARED_END
#endif

// Which rays an invocation traces, and of which count.
#extension GL_EXT_scalar_block_layout : require
#include "shared/features.h"
#include "shared/swizzle.h"
#include "shared/wavefront.h"

layout(constant_id = kTraceThreads) const uint kDriverThreads = 1u; // threads that run contiguous ranges of workgroups
layout(constant_id = kTraceStack) const uint kStack = 0u;

// lavapipe ends all loops of a subgroup, silently, after 65 535 iterations of any of them. Giving a ray up before that keeps the loss visible.
const uint kMaxSteps = 60000u / kChunkRounds;

struct RayRun {
    uint next, end; // this invocation's rays: every kChunkRun-th of them
};

RayRun runOfRays(uint invocation, uint count) {
    const uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    const uint group = swizzleGroup(gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, groups, kDriverThreads);
    const uint first = group * kTraceChunk + chunkItem(invocation, 0u);
    return RayRun(first, min(count, first + kChunkRounds * kChunkRun));
}

// How the lanes of a workgroup share the rays of its chunk.
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "shared/swizzle.h"
#include "shared/wavefront.h"

layout(constant_id = 0) const uint kDriverThreads = 1u; // threads that run contiguous ranges of workgroups
layout(constant_id = 1) const bool kRefill = false;     // lanes that have finished take new rays before the others have

shared uint queueNext;
uint queueEnd;

// The workgroup's part of `count` rays.
void openQueue(uint count) {
    const uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    const uint group = swizzleGroup(gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, groups, kDriverThreads);
    if (gl_LocalInvocationIndex == 0u)
        queueNext = group * kTraceChunk;
    queueEnd = min(count, group * kTraceChunk + kTraceChunk);
    barrier();
}

// The next ray of the chunk, or kNone.
uint takeFromQueue() {
    const uvec4 takers = subgroupBallot(true);
    uint base = 0u;
    if (subgroupElect())
        base = atomicAdd(queueNext, subgroupBallotBitCount(takers));
    const uint item = subgroupBroadcastFirst(base) + subgroupBallotExclusiveBitCount(takers);
    return item < queueEnd ? item : kNone;
}

// Whether at least a part of the subgroup's lanes (in eighths) say yes.
bool laneShare(bool yes, uint eighths) { return subgroupBallotBitCount(subgroupBallot(yes)) * 8u >= gl_SubgroupSize * eighths; }

// How the lanes of a subgroup share its part of the rays, and how long they may go on.
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "shared/features.h"
#include "shared/swizzle.h"
#include "shared/wavefront.h"

layout(constant_id = kTraceThreads) const uint kDriverThreads = 1u; // threads that run contiguous ranges of workgroups
layout(constant_id = kTraceRefill) const bool kRefill = false;

// lavapipe ends all loops of a subgroup, silently, after 65 535 iterations of any of them. Stopping before that keeps the loss visible.
const uint kMaxIterations = 60000u;

uint queueNext, queueEnd; // the subgroup's own, equal in all its lanes
uint iterations;          // of all loops so far
uint unfinished;          // rays of this lane that were given up

void openQueue(uint count) {
    const uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    const uint group = swizzleGroup(gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, groups, kDriverThreads);
    const uint share = kTraceChunk / gl_NumSubgroups;
    queueNext = min(count, group * kTraceChunk + gl_SubgroupID * share);
    queueEnd = min(count, queueNext + share);
    iterations = 0u;
    unfinished = 0u;
}

bool queueEmpty() { return queueNext == queueEnd; }

// Gives each lane that wants one the next ray, or kNone when there is none left. To be called by all lanes.
uint takeFromQueue(bool wanted) {
    const uvec4 takers = subgroupBallot(wanted);
    const uint item = queueNext + subgroupBallotExclusiveBitCount(takers);
    queueNext = min(queueEnd, queueNext + subgroupBallotBitCount(takers));
    return item < queueEnd ? item : kNone;
}

// Whether any lane, and at least a part of the subgroup (in eighths), says yes.
bool laneShare(bool yes, uint eighths) { return subgroupBallotBitCount(subgroupBallot(yes)) * 8u >= max(1u, gl_SubgroupSize * eighths); }

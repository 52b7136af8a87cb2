// Which rays a subgroup traces: a run of its own, each lane every gl_SubgroupSize-th of it.
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#include "shared/features.h"
#include "shared/swizzle.h"
#include "shared/wavefront.h"

layout(constant_id = kTraceThreads) const uint kDriverThreads = 1u; // threads that run contiguous ranges of workgroups
layout(constant_id = kTraceStack) const uint kStack = 0u;

// lavapipe ends all loops of a subgroup, silently, after 65 535 iterations of any of them. Giving a ray up before that keeps the loss visible.
const uint kMaxSteps = 60000u / (kTraceChunk / kVertexGroup);

struct RayRun {
    uint next, end; // this lane's first ray, and the end of the subgroup's
};

RayRun runOfRays(uint count) {
    const uint groups = gl_NumWorkGroups.x * gl_NumWorkGroups.y;
    const uint group = swizzleGroup(gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, groups, kDriverThreads);
    const uint share = kTraceChunk / gl_NumSubgroups, first = group * kTraceChunk + gl_SubgroupID * share;
    return RayRun(first + gl_SubgroupInvocationID, min(count, first + share));
}

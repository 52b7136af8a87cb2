// Sorts the vertices of a bounce by what they take to shade, so that each class has a kernel with what it needs and no more: a CPU driver spends the
// instructions of a branch on every lane, whether one takes it or not.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "scene/features.glsl"
#include "scene/material_tables.glsl"
#define CMPG_READ_HITS
#define CMPG_READ_COPIES
#include "scene/queues.glsl"
#include "lib/dispatch.glsl"
#include "shared/swizzle.h"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { BouncePush push; };
layout(binding = kBindCounts, scalar) buffer Counts { QueueCounts counts[]; };
layout(binding = kBindCountsHere, scalar) uniform Here { QueueCounts here; };
layout(binding = kBindSorted, scalar) writeonly buffer Sorted { uint sorted[]; };

uint classOf(Hit hit) {
    if (hit.t < 0.0) return kClassEscaped;
    return materialTexel(triangleIndices(hit.triangle).w * kMaterialTexels + 1).w >> kMaterialClassShift & kMaterialClassMask;
}

// Each invocation sorts kChunkRounds vertices, so that a subgroup asks once for the places of all.
void main() {
    const uint count = kRoulette ? here.vertices : here.rays;
    const uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, begin = group * kTraceChunk + chunkItem(gl_LocalInvocationIndex, 0);
    if (push.count == 0) return;
    uint shadingClass[kChunkRounds], rank[kChunkRounds];
    uvec4 totals = uvec4(0); // a class each
    for (uint r = 0; r < kChunkRounds; ++r) {
        const uint slot = begin + r * kChunkRun;
        shadingClass[r] = slot < count ? classOf(readHit(kRoulette ? readCopy(slot).ray : slot)) : kVertexClasses;
        for (uint c = 0; c < kVertexClasses; ++c) {
            if ((kClasses >> c & 1u) == 0) continue;
            const uvec4 votes = subgroupBallot(shadingClass[r] == c);
            if (shadingClass[r] == c) rank[r] = totals[c] + subgroupBallotExclusiveBitCount(votes);
            totals[c] += subgroupBallotBitCount(votes);
        }
    }
    // Places are handed out in any order, results do not depend on it. The group counts of the shading kernels grow with the last place.
    uvec4 first = uvec4(0);
    if (subgroupElect()) {
        for (uint c = 0; c < kVertexClasses; ++c) {
            if (totals[c] == 0) continue;
            first[c] = atomicAdd(counts[push.bounce].classes[c], totals[c]);
            atomicMax(counts[push.bounce].classGroups[c].x, (first[c] + totals[c] + kVertexGroup - 1) / kVertexGroup);
        }
    }
    first = subgroupBroadcastFirst(first);
    for (uint r = 0; r < kChunkRounds; ++r)
        if (shadingClass[r] != kVertexClasses) sorted[shadingClass[r] * push.count + first[shadingClass[r]] + rank[r]] = begin + r * kChunkRun;
}

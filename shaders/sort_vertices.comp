// Sorts the vertices of a bounce by what they take to shade, so that each class has a kernel with what it needs and no more: a CPU driver spends the
// instructions of a branch on every lane, whether one takes it or not.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#include "scene/features.glsl"
#include "scene/material_tables.glsl"
#define CMPG_READ_RAYS
#define CMPG_READ_HITS
#define CMPG_READ_COPIES
#include "scene/queues.glsl"
#include "lib/dispatch.glsl"
#include "shared/swizzle.h"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { BouncePush push; };
layout(binding = kBindCounts, scalar) buffer Counts { QueueCounts counts[]; };
layout(binding = kBindCountsHere, scalar) uniform Here { QueueCounts here; };
layout(binding = kBindCountsFirst, scalar) uniform First { QueueCounts firstCounts; };
layout(binding = kBindSorted, scalar) writeonly buffer Sorted { uint sorted[]; };

const bool kUnlit = (kClasses >> kClassUnlit & 1u) != 0;

uint classOf(uint ray) {
    const Hit hit = readHit(ray);
    if (hit.t < 0.0) return kClassEscaped;
    const uint surface = materialTexel(triangleIndices(hit.triangle).w * kMaterialTexels + 1).w >> kMaterialClassShift & kMaterialClassMask;
    if (kUnlit && surface == kClassPlain && (readRay(ray).path & kLightCounts) == 0) return kClassUnlit;
    return surface;
}

// Each invocation sorts kChunkRounds vertices, so that a subgroup asks once for the places of all.
void main() {
    const uint count = kRoulette ? here.vertices : here.rays;
    const uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x, begin = group * kTraceChunk + chunkItem(gl_LocalInvocationIndex, 0);
    if (push.count == 0 || (kRoulette && firstCounts.overflow != 0)) return; // the batch is void: nothing is shaded
    uint shadingClass[kChunkRounds], rank[kChunkRounds];
    uint totals[kVertexClasses], first[kVertexClasses];
    for (uint c = 0; c < kVertexClasses; ++c) totals[c] = first[c] = 0;
    for (uint r = 0; r < kChunkRounds; ++r) {
        const uint slot = begin + r * kChunkRun;
        shadingClass[r] = slot < count ? classOf(kRoulette ? readCopy(slot).ray : slot) : kVertexClasses;
        for (uint c = 0; c < kVertexClasses; ++c) {
            if ((kClasses >> c & 1u) == 0) continue;
            const uvec4 votes = subgroupBallot(shadingClass[r] == c);
            if (shadingClass[r] == c) rank[r] = totals[c] + subgroupBallotExclusiveBitCount(votes);
            totals[c] += subgroupBallotBitCount(votes);
        }
    }
    // Places are handed out in any order, results do not depend on it.
    if (subgroupElect()) {
        for (uint c = 0; c < kVertexClasses; ++c) {
            if (totals[c] == 0) continue;
            first[c] = atomicAdd(counts[push.bounce].classes[c], totals[c]);
            GROW_GROUPS(counts[push.bounce].classGroups[c], first[c], totals[c], kVertexGroup)
        }
    }
    for (uint c = 0; c < kVertexClasses; ++c)
        if ((kClasses >> c & 1u) != 0) first[c] = c * push.count + subgroupBroadcastFirst(first[c]);
    for (uint r = 0; r < kChunkRounds; ++r) {
        uint place = rank[r];
        for (uint c = 0; c < kVertexClasses; ++c) place += shadingClass[r] == c ? first[c] : 0;
        if (shadingClass[r] != kVertexClasses) sorted[place] = begin + r * kChunkRun;
    }
}

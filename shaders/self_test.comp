// A little of all that the other kernels rely on, with known answers, for a device that is being opened: texel reads in uneven loops
// over a stack, places handed out by a ballot, sums over subgroups and of 64-bit integers, structs in scalar layout, indirect dispatch,
// uniform buffers that an earlier dispatch wrote.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#ifndef CMPG_PORTABLE
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#include "shared/bindings.h"
#include "shared/self_test.h"
#include "lib/dispatch.glsl"
#include "lib/read_buffers.glsl"
#include "scene/integer_sums.glsl"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { SelfTestPush push; };
READ_UVEC4(nodeAt, kBindTestNodes)
READ_VEC4(vectorAt, kBindTestVectors)
READ_FLOAT(numberAt, kBindTestNumbers)
READ_UINT(wordAt, kBindTestWords)
layout(binding = kBindTestCounts, scalar) buffer Counts { SelfTestCounts counts; };
layout(binding = kBindTestCountsHere, scalar) uniform Here { SelfTestCounts here; };
layout(binding = kBindTestSum, scalar) buffer Sum { INTEGER_SUM sum; };
layout(binding = kBindTestResults, scalar) writeonly buffer Results { SelfTestResult results[]; };

uint hash(uint item, uint node) {
    uint h = item * 0x9e3779b1u + node * 0x85ebca6bu;
    h ^= h >> 15;
    return h * 0x2c1b3c6du;
}

void main() {
    const uint item = globalIndex();
    if (push.stage == kSelfTestPrepare) {
        if (item == 0u) {
            counts.groups = uvec3((push.items + gl_WorkGroupSize.x - 1u) / gl_WorkGroupSize.x, 1u, 1u);
            counts.items = push.items;
        }
        return;
    }
    if (item >= here.items) return;
    SelfTestResult result = SelfTestResult(item, vec3(0), 0u, 0u);
    uint stack[kSelfTestStack];
    uint top = 1u;
    stack[0] = 0u;
    while (top > 0u) {
        const uint index = stack[--top];
        const uvec4 node = nodeAt(index);
        ++result.visits;
        if (node.x == 0u) {
            result.sum += vectorAt(node.y).xyz * numberAt(node.z);
            result.words ^= wordAt(node.w);
        } else {
            for (uint child = node.x; child < node.x + 2u; ++child)
                if (hash(item, child) < 0xc0000000u) stack[top++] = child;
        }
    }

    const bool wanted = (result.visits & 1u) != 0u;
    const uvec4 votes = subgroupBallot(wanted);
    uint first = 0u;
    if (subgroupElect()) first = atomicAdd(counts.places, subgroupBallotBitCount(votes));
    first = subgroupBroadcastFirst(first);
    if (wanted) results[first + subgroupBallotExclusiveBitCount(votes)] = result;

    const uint visits = subgroupAdd(result.visits);
    if (subgroupElect()) atomicAdd(counts.visits, visits);

    const uvec2 words = uvec2(hash(item, 0u), item); // low ones whose sum carries
    uint ignored;
    ADD_INTEGER(sum, words, ignored)
}

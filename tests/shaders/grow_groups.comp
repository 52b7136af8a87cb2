// Takes places of a queue whose group counts grow with it, for workgroups of 64.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "lib/dispatch.glsl"
layout(local_size_x = 64) in;
layout(binding = 0, scalar) buffer Queue { uvec3 groups; uint taken; } queue;
layout(push_constant, scalar) uniform Push { uint count; } push;

void main() {
    const uint i = globalIndex();
    if (i >= push.count) return;
    const uint wanted = i % 7;
    if (wanted == 0) return;
    const uint first = atomicAdd(queue.taken, wanted);
    GROW_GROUPS(queue.groups, first, wanted, 64)
}

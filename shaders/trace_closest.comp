// Finds the nearest hit of every ray of a bounce.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "lib/trace_queue.glsl"
#include "scene/trace_masks.glsl"
#include "lib/traverse.glsl"

layout(binding = kBindRays, scalar) readonly buffer Rays { Ray rays[]; };
layout(binding = kBindHits, scalar) writeonly buffer Hits { Hit hits[]; };
layout(binding = kBindCounts, scalar) buffer Counts { QueueCounts counts[]; };
layout(push_constant, scalar) uniform Push { BouncePush push; };

void main() {
    if (push.count == 0u)
        return;
    openQueue(min(push.count, counts[push.bounce].rays));
    uint mine = kNone;
    rayCursor = kNone;
    do {
        const bool idle = rayCursor == kNone;
        if (idle && mine != kNone)
            hits[mine] = endRay();
        const uint taken = takeFromQueue(idle);
        if (idle)
            mine = taken;
        if (idle && mine != kNone)
            beginRay(rays[mine].origin, rays[mine].direction, uintBitsToFloat(0x7f800000u));
        walk();
    } while (laneShare(mine != kNone, 0u));
    if (unfinished > 0u)
        atomicAdd(counts[push.bounce].unfinished, unfinished);
}

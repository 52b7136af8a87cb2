// Finds for every shadow ray of a bounce whether anything stands in its way.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "lib/trace_queue.glsl"
#include "scene/trace_masks.glsl"

#define CMPG_ANY_HIT
#include "lib/traverse.glsl"

layout(binding = kBindShadowRays, scalar) readonly buffer ShadowRays { ShadowRay shadowRays[]; };
layout(binding = kBindVisibility, scalar) writeonly buffer Visibility { uint visible[]; };
layout(binding = kBindCounts, scalar) buffer Counts { QueueCounts counts[]; };
layout(push_constant, scalar) uniform Push { BouncePush push; };

void main() {
    if (push.count == 0u)
        return;
    openQueue(min(push.count, counts[push.bounce].shadowRays));
    uint mine = kNone;
    rayCursor = kNone;
    do {
        const bool idle = rayCursor == kNone;
        if (idle && mine != kNone)
            visible[mine] = rayBlock == kNone ? 1u : 0u;
        const uint taken = takeFromQueue(idle);
        if (idle)
            mine = taken;
        if (idle && mine != kNone)
            beginRay(shadowRays[mine].origin, shadowRays[mine].direction, shadowRays[mine].distance);
        walk();
    } while (laneShare(mine != kNone, 0u));
    if (unfinished > 0u)
        atomicAdd(counts[push.bounce].unfinished, unfinished);
}

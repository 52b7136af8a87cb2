// Finds for every shadow ray of a bounce whether anything stands in its way.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "lib/trace_queue.glsl"

bool acceptHit(uint triangle, vec2 barycentrics) { return true; }
#define CMPG_ANY_HIT
#include "lib/traverse.glsl"

layout(binding = kBindShadowRays, scalar) readonly buffer ShadowRays { ShadowRay shadowRays[]; };
layout(binding = kBindVisibility, scalar) writeonly buffer Visibility { uint visible[]; };
layout(binding = kBindCounts, scalar) readonly buffer Counts { QueueCounts counts[]; };
layout(push_constant, scalar) uniform Push { BouncePush push; };

void main() {
    if (push.count == 0u)
        return;
    openQueue(min(push.count, counts[push.bounce].shadowRays));
    uint mine = kNone;
    rayCursor = kNone;
    while (true) {
        // Lanes without a ray take one.
        if (rayCursor == kNone) {
            if (mine != kNone)
                visible[mine] = rayBlock == kNone ? 1u : 0u;
            mine = takeFromQueue();
            if (mine != kNone)
                beginRay(shadowRays[mine].origin, shadowRays[mine].direction, shadowRays[mine].distance);
        }
        if (!anyLane(rayCursor != kNone))
            break;
        do {
            if (rayCursor != kNone)
                stepRay();
        } while (keepStepping(rayCursor != kNone));
    }
}

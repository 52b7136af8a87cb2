// Finds the nearest hit of every ray of a bounce.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "lib/trace_queue.glsl"

bool acceptHit(uint triangle, vec2 barycentrics) { return true; }
#include "lib/traverse.glsl"

layout(binding = kBindRays, scalar) readonly buffer Rays { Ray rays[]; };
layout(binding = kBindHits, scalar) writeonly buffer Hits { Hit hits[]; };
layout(binding = kBindCounts, scalar) readonly buffer Counts { QueueCounts counts[]; };
layout(push_constant, scalar) uniform Push { BouncePush push; };

void main() {
    if (push.count == 0u)
        return;
    openQueue(min(push.count, counts[push.bounce].rays));
    uint mine = kNone;
    rayCursor = kNone;
    while (true) {
        // Lanes without a ray take one.
        if (rayCursor == kNone) {
            if (mine != kNone)
                hits[mine] = endRay();
            mine = takeFromQueue();
            if (mine != kNone)
                beginRay(rays[mine].origin, rays[mine].direction, uintBitsToFloat(0x7f800000u));
        }
        if (!anyLane(rayCursor != kNone))
            break;
        do {
            if (rayCursor != kNone)
                stepRay();
        } while (keepStepping(rayCursor != kNone));
    }
}

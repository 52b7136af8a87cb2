// Finds for every shadow ray of a bounce whether anything stands in its way.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "lib/trace_queue.glsl"
#include "scene/trace_masks.glsl"
#define CMPG_READ_SHADOW_RAYS
#include "scene/queues.glsl"

#define CMPG_ANY_HIT
#include "lib/traverse.glsl"

layout(binding = kBindVisibility, scalar) writeonly buffer Visibility { uint visible[]; };
layout(binding = kBindCounts, scalar) buffer Counts { QueueCounts counts[]; };
layout(binding = kBindCountsHere, scalar) uniform Here { QueueCounts here; };
layout(push_constant, scalar) uniform Push { BouncePush push; };

void main() {
    if (push.count == 0u)
        return;
    const RayRun run = runOfRays(gl_LocalInvocationIndex, min(push.count, here.shadowRays));
    for (uint i = run.next; i < run.end; i += kChunkRun) {
        const ShadowRay ray = readShadowRay(i);
        beginRay(ray.origin, ray.direction, ray.distance);
        if (walk())
            atomicAdd(counts[push.bounce].unfinished, 1u);
        visible[i] = rayBlock == kNone ? 1u : 0u;
    }
}

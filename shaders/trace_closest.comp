// Finds the nearest hit of every ray of a bounce.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;
#include "lib/trace_queue.glsl"
#include "scene/trace_masks.glsl"
#define CMPG_READ_RAYS
#include "scene/queues.glsl"
#include "lib/traverse.glsl"

layout(binding = kBindHits, scalar) writeonly buffer Hits { uvec4 hits[]; };
layout(binding = kBindCounts, scalar) buffer Counts { QueueCounts counts[]; };
layout(binding = kBindCountsHere, scalar) uniform Here { QueueCounts here; };
layout(push_constant, scalar) uniform Push { BouncePush push; };

void main() {
    if (push.count == 0u)
        return;
    const RayRun run = runOfRays(gl_LocalInvocationIndex, min(push.count, here.rays));
    for (uint i = run.next; i < run.end; i += kChunkRun) {
        const Ray ray = readRay(i);
        beginRay(ray.origin, ray.direction, uintBitsToFloat(0x7f800000u));
        if (walk())
            atomicAdd(counts[push.bounce].unfinished, 1u);
        const Hit hit = endRay();
        WRITE_HIT(hits, i, hit)
    }
}

// What each path of a reverse pass contributed, for its variance, and the derivative it met at its first vertex.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "scene/features.glsl"
#include "shared/bindings.h"
#include "shared/batch.h"
#define CMPG_READ_PATHS
#define CMPG_READ_ADJOINTS
#include "scene/queues.glsl"
#include "lib/dispatch.glsl"
#include "lib/math.glsl"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { BouncePush push; };
layout(binding = kBindBatch, scalar) uniform BatchBlock { Batch batch; };
QUEUE_UINT(arrivalWord, kBindArrivals)
QUEUE_UINT(momentWord, kBindMoments)
QUEUE_UINT(derivativeWord, kBindDerivatives)
layout(binding = kBindPathMoments, scalar) writeonly buffer PathMoments { PathMoment pathMoments[]; };

void main() {
    const uint path = globalIndex();
    if (push.count == 0 || path >= batch.paths) return;
    Arrival arrival = Arrival(path, 1, 1.0);
    if (kRoulette) arrival = READ_ARRIVAL(arrivalWord, path);
    vec3 own = vec3(0);
    float below = 0.0;
    uint entry = kNone;
    vec3 derivative = vec3(0);
    for (uint i = 0; i < arrival.count; ++i) { // at most kMaxSplit
        const VertexMoment m = READ_MOMENT(momentWord, arrival.first + i);
        own += m.own;
        below = rootSum(below, m.below);
        entry = m.entry; // copies stand at one point
        if (kRecord) {
            const DerivativeParts parts = READ_PARTS(derivativeWord, arrival.first + i);
            derivative += arrival.weight * (parts.plus + parts.minus);
        }
    }
    const vec3 adjoint = abs(readAdjoint(readPath(path).x));
    const float reference = (adjoint.x + adjoint.y + adjoint.z) * (derivative.x + derivative.y + derivative.z) * (1.0 / 9.0);
    pathMoments[path] = PathMoment(own, below, entry, reference);
}

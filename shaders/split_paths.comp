// Roulette and splitting on arrival, before light and direction are drawn: a path goes on as often as its expected contribution to the
// gradient, relative to that of a camera path, asks for (adjoint-driven; Vorba and Křivánek 2016, here by derivative-to-go).
//     q = |adjoint| (A_i . S + b_i . T) / reference,    S, T: the cell's means of R and of the L1 norm of T
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#include "scene/features.glsl"
#include "scene/buffers.glsl"
#define CMPG_READ_RAYS
#define CMPG_READ_HITS
#define CMPG_READ_PREFIXES
#define CMPG_READ_PATHS
#define CMPG_READ_ADJOINTS
#include "scene/queues.glsl"
#include "lib/physics.glsl"
#include "lib/dispatch.glsl"
#include "scene/guide_lookup.glsl"
layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { BouncePush push; };
layout(binding = kBindCounts, scalar) buffer Counts { QueueCounts counts[]; };
layout(binding = kBindCountsHere, scalar) uniform Here { QueueCounts here; };
layout(binding = kBindArrivals, scalar) writeonly buffer Arrivals { Arrival arrivals[]; };
layout(binding = kBindCopies, scalar) writeonly buffer Copies { uvec4 copies[]; };

const float kLeastCopies = 0.1;

// Expected number of copies; 1 where the guide knows nothing, and where there is emission to be taken in.
float expectedCopies(Ray ray, Hit hit, Prefix prefix, vec3 adjoint) {
    if (hit.t < 0.0) return 1.0;
    const uint flags = materialTexel(triangleIndices(hit.triangle).w * kMaterialTexels + 1).w;
    if (kEmission && (flags & kMaterialEmissive) != 0) return 1.0;
    const uvec4 cell = guideCellTexel(guideCellOf(ray.origin + hit.t * ray.direction) * kGuideCellTexels);
    const float reflected = uintBitsToFloat(cell.y), derivative = uintBitsToFloat(cell.z);
    if (!(reflected > 0.0) || !(guide.reference > 0.0)) return 1.0;
    const float expected = meanOf(prefix.tangent) * reflected + meanOf(prefix.throughput) * derivative;
    const float q = meanOf(abs(adjoint)) * (expected / guide.reference);
    const float most = float(min(kMaxSplit, kMaxCopies / prefix.copies)); // whole: chance rounds q up
    if (!(q <= most)) return most; // no number too, out of overflow
    return clamp(q, kLeastCopies, most);
}

void main() {
    const uint slot = globalIndex();
    if (push.count == 0 || slot >= here.rays) return;
    const Ray ray = readRay(slot);
    const uvec2 path = readPath(pathOf(ray));
    Prefix prefix = Prefix(vec3(1), 0, vec3(0), 1);
    if (push.bounce > 0) prefix = readPrefix(slot);
    const float q = expectedCopies(ray, readHit(slot), prefix, readAdjoint(path.x));
    const SampleKey key = SampleKey(streamKey(batch.seed.x, batch.seed.y, batch.step, batch.pass), batch.firstPixel + path.x, path.y, prefix.branch, push.bounce);
    const uint count = uint(q) + (sampleSet(key, kSetRoulette).x >= 1.0 - fract(q) ? 1u : 0u); // q + u would round up to the next number
    // One atomic a subgroup; places are handed out in any order, results do not depend on it.
    const uint taken = subgroupAdd(count);
    uint first = 0;
    if (taken != 0 && subgroupElect()) {
        first = atomicAdd(counts[push.bounce].vertices, taken);
        const uint fits = min(first + taken, push.count) - min(first, push.count); // a void batch dispatches no more than the pool holds
        GROW_GROUPS(counts[push.bounce].vertexGroups, first, fits, kVertexGroup)
        GROW_GROUPS(counts[push.bounce].sortGroups, first, fits, kTraceChunk)
    }
    first = subgroupBroadcastFirst(first) + subgroupExclusiveAdd(count);
    const float weight = 1.0 / q;
    if (first + count > push.count) { // the batch is void
        counts[0].overflow = 1;
        return;
    }
    arrivals[slot] = Arrival(first, count, weight);
    for (uint i = 0; i < count; ++i) {
        const Copy copy = Copy(slot, i, weight, prefix.copies * count);
        WRITE_COPY(copies, first + i, copy)
    }
}

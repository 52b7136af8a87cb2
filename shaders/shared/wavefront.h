// What travels between the kernels of one bounce, and the tape they leave behind.
#ifndef CMPG_SHARED_WAVEFRONT
#define CMPG_SHARED_WAVEFRONT
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

CMPG_CONST kNone = 0xffffffffu;
CMPG_CONST kTraceChunk = 256; // rays a workgroup of trace_closest or trace_shadow takes
CMPG_CONST kVertexGroup = 64; // invocations of a workgroup of the other kernels

// A ray to be continued. Its place in the queue is the slot of the vertex it will create in this bounce's pool.
struct Ray {
    vec3 origin;
    uint path; // index of the path in the batch, and kLightCounts
    vec3 direction; // unit length
    float pdf; // solid-angle density the direction was drawn with (mixture); 0 for camera rays, kSingleDirection
};

// In Ray::path: the light that the path finds from here on is a factor of what the pass makes. Without it the path has met nothing that is
// differentiated yet, and only that is looked for.
CMPG_CONST kLightCounts = 0x80000000u;

#ifdef __cplusplus
constexpr float kSingleDirection = -1; // Ray::pdf of a single direction of a smooth boundary, which no light sample can find
#else
const float kSingleDirection = -1.0;
#endif

// What a path has collected on the way to the vertex its ray will find.
struct Prefix {
    vec3 throughput; // b_i
    uint branch; // random numbers of the copies of a split path differ by it
    vec3 tangent; // A_i >= ||db_i||_1: the sum over all parameters of the absolute derivatives of the throughput
    uint copies; // product of the splits so far, at most kMaxCopies
};

// A ray that has arrived, when roulette is on: it goes on as `count` vertices side by side, each with weight 1/q.
struct Arrival {
    uint first, count;
    float weight;
};
// The vertex's ray, and which of the arrival's copies it is.
struct Copy {
    uint ray, index;
    float weight;
    uint copies; // as Prefix::copies, this split included
};
CMPG_CONST kMaxSplit = 4; // copies of one arrival
CMPG_CONST kMaxCopies = 64; // of one path at one bounce, so that a path always fits into the pools

// Where a ray ended. t < 0: it left the scene.
struct Hit {
    float t;
    uint triangle; // in BVH order
    vec2 barycentrics; // weights of the second and third vertex
};

// A light sample waiting for its visibility.
struct ShadowRay {
    vec3 origin;
    float distance; // the segment is open at both ends: occluders lie in (0, distance)
    vec3 direction; // unit length
    uint slot; // vertex it belongs to
};

CMPG_CONST kShareUnits = 255;

// What a vertex takes to shade, which sort_vertices decides. A kernel of its own shades each class, specialised for what is met there.
CMPG_CONST kClassEscaped = 0; // the ray left the scene
CMPG_CONST kClassPlain = 1; // of surfaces: ShadingClass in src/scene/features.h
CMPG_CONST kClassDiffuse = 2;
CMPG_CONST kClassOther = 3;
CMPG_CONST kClassUnlit = 4; // plain, on a path whose light does not count yet (kLightCounts)
CMPG_CONST kVertexClasses = 5;

// How much there is to do in one bounce. The group counts are arguments of indirect dispatches; kernels that fill a queue make them grow with it (GROW_GROUPS in
// lib/dispatch.glsl).
struct QueueCounts {
    uint rays;
    uint vertices; // as many as rays, unless roulette makes copies
    uint shadowRays;
    uint unfinished; // rays given up because they met too many records; anything but 0 deserves a warning
    uint overflow; // of bounce 0: copies found no place at some bounce, and the batch is void
    uint drawn, guided, dead; // directions drawn where the guide knew something; from the guide; of these, those that led nowhere
    uint lightShare; // sum over the drawn of the share of P in the mixture, in units of 1 / kShareUnits
    uvec3 rayGroups; // tracing kernels: kTraceChunk rays a workgroup
    uvec3 shadowGroups;
    uvec3 arrivalGroups; // kernels that take one ray an invocation: kVertexGroup a workgroup
    uvec3 vertexGroups; // with a roulette, where vertices are more or fewer than rays: kernels that take one an invocation
    uvec3 sortGroups; // the same: sort_vertices, kTraceChunk vertices a workgroup
    uint classes[kVertexClasses]; // vertices of each
    uvec3 classGroups[kVertexClasses];
    uint reserved[20]; // a uniform buffer begins at multiples of 256 bytes
};

// One vertex of the tape, three texels: the local factors of the estimator, nothing multiplied by the prefix or divided by it.
//   R_i = N_i + w_i (E_{i+1} + R_{i+1})
struct Vertex {
    vec3 emission; // E_i: found here, times its MIS weight
    uint child; // ray of the next bounce, whose slot is also its vertex's unless roulette is on; kNone where the path ends
    vec3 direct; // N_i before visibility
    uint shadow; // its shadow ray, kNone without a light sample
    vec3 weight; // w_i = f_i / p_i
    uint path;
};

// What a vertex and all after it make of the parameters' terms: sums over terms of positive and of negated negative ones, emission
// found at the vertex included. plus + minus is the L1 norm |dE_i| + T_i.
struct DerivativeParts {
    vec3 plus, minus;
};

// Second moment of a path's contributions: those of this vertex, where they went, and the norm of all further along (not its square, which would
// overflow at a radiance of 1e20).
struct VertexMoment {
    vec3 own;
    float below;
    uint entry; // gradient entry most of it went to
};

// The same of a path: its first vertex's contributions, over all copies, and the norm of all others.
struct PathMoment {
    vec3 own;
    float below;
    uint entry;
    float reference; // |adjoint| times the L1 norm of the derivative met at the first vertex
};

// Queue-wide arguments of the kernels that run once per bounce.
struct BouncePush {
    uint bounce;
    uint count; // upper bound of the items; 0: do nothing (used to warm kernels up)
    uint depth; // vertices of a path at most; no constant of kernels, which serve any depth
};

// The backward scan; a dispatch adds to the gradient entries [firstEntry, firstEntry + entries).
struct ScanPush {
    uint bounce;
    uint count;
    uint firstEntry;
    uint entries;
    uint keepRecords; // 0: a recording pass leaves none
    uint shadingClass; // whose vertices; kVertexClasses: all
    uint suffixes; // 0: another dispatch passes on what the vertices reflect
    uint depth; // as above
};

CMPG_SHARED_END
#endif

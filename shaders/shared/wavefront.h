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
    uint path; // index of the path in the batch
    vec3 direction; // unit length
    float pdf; // solid-angle density the direction was drawn with (mixture); 0 for camera rays
};

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

// How much there is to do in one bounce. The group counts are arguments of indirect dispatches, folded into y above 65 535.
struct QueueCounts {
    uint rays;
    uint shadowRays;
    uvec3 rayGroups; // tracing kernels: kTraceChunk rays a workgroup
    uvec3 shadowGroups;
    uvec3 vertexGroups; // kernels that take one vertex an invocation: kVertexGroup a workgroup
};

// One vertex of the tape: the local factors of the estimator, nothing multiplied by the prefix or divided by it.
//   R_i = N_i + w_i (E_{i+1} + R_{i+1})
struct Vertex {
    vec3 suffix; // while tracing: E_i, the emission found here times its MIS weight; after the scan: E_i + R_i
    uint child; // slot in the next bounce's pool, kNone where the path ends
    vec3 direct; // N_i before visibility
    uint shadow; // its shadow ray, kNone without a light sample
    vec3 weight; // w_i = f_i / p_i
    uint path;
};

// Queue-wide arguments of the kernels that run once per bounce.
struct BouncePush {
    uint bounce;
    uint count; // upper bound of the items; 0: do nothing (used to warm kernels up)
};

// The backward scan; a dispatch adds to the gradient entries [firstEntry, firstEntry + entries).
struct ScanPush {
    uint bounce;
    uint count;
    uint firstEntry;
    uint entries;
};

CMPG_SHARED_END
#endif

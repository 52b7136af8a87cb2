// What travels between the kernels of one bounce.
#ifndef CMPG_SHARED_WAVEFRONT
#define CMPG_SHARED_WAVEFRONT
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

CMPG_CONST kNone = 0xffffffffu;

CMPG_CONST kTraceChunk = 256; // rays a workgroup of trace_closest or trace_shadow takes

// A ray to be continued. Queue index = slot of the vertex it will create in this bounce's pool.
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

// How much there is to do in one bounce. The group counts are arguments of indirect dispatches, ceil(rays / kTraceChunk) folded into
// y above 65 535.
struct QueueCounts {
    uint rays;
    uint shadowRays;
    uint unfinished; // rays given up because they met too many records; anything but 0 deserves a warning
    uint reserved1;
    uvec3 rayGroups;
    uint reserved2;
    uvec3 shadowGroups;
    uint reserved3;
};

// Push constants of trace_closest and trace_shadow.
struct TracePush {
    uint bounce; // index of the QueueCounts
    uint count;  // upper bound of the number of rays; 0: do nothing
};

CMPG_SHARED_END
#endif

// Binding numbers: one name per buffer, the same in every kernel.
#ifndef CMPG_SHARED_BINDINGS
#define CMPG_SHARED_BINDINGS
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

// Scene, read only.
CMPG_CONST kBindNodes = 0;      // texels of BvhNode, vec4
CMPG_CONST kBindTriangles = 1;  // three vec4 a triangle in BVH order: v0, v1 - v0, v2 - v0 (w unused)
// Rays and hits of one bounce.
CMPG_CONST kBindRays = 10;
CMPG_CONST kBindHits = 11;
CMPG_CONST kBindShadowRays = 12;
CMPG_CONST kBindCounts = 13; // QueueCounts per bounce

CMPG_SHARED_END
#endif

// Binding numbers: one name per buffer, the same in every kernel.
#ifndef CMPG_SHARED_BINDINGS
#define CMPG_SHARED_BINDINGS
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

// Scene, read only.
CMPG_CONST kBindNodes = 0;      // Bvh::records: box nodes and leaf blocks, 4 uvec4 texels each
// Rays and hits of one bounce.
CMPG_CONST kBindRays = 10;
CMPG_CONST kBindHits = 11;
CMPG_CONST kBindShadowRays = 12;
CMPG_CONST kBindCounts = 13;     // QueueCounts per bounce
CMPG_CONST kBindVisibility = 14; // one uint per shadow ray: 1 = nothing in between

CMPG_SHARED_END
#endif

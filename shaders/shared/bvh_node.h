// The acceleration structure as the kernels read it: one array of 64-byte records (4 texels, one cache line), each either a
// box node or a leaf block. Both kinds have one size so that a SIMD step can advance lanes at either kind with the same fetches.
#ifndef CMPG_SHARED_BVH_NODE
#define CMPG_SHARED_BVH_NODE
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

CMPG_CONST kMaxLeafTriangles = 8;
CMPG_CONST kMaxBvhDepth = 48;      // box nodes on a path from the root; the traversal stack holds as many entries
CMPG_CONST kLeafBit = 0x80000000u; // in a child reference: the record is a leaf block; the other bits are its index
CMPG_CONST kLastBlock = 0x100u;    // in LeafBlock::turns: no further block belongs to this leaf

// Both children's boxes. A child that does not exist has low > high and is never entered.
struct BvhNode {
    vec3 leftLow;
    uint left;
    vec3 leftHigh;
    uint right;
    vec3 rightLow;
    uint pad0;
    vec3 rightHigh;
    uint pad1;
};

// Two triangles that share the edge v0 v2: A = (v0, v1, v2) and B = (v0, v2, v3); a single triangle has v3 = v2.
// They are numbers `first` and `first + 1` in BVH order. Sharing saves a third of the reads and arithmetic.
struct LeafBlock {
    vec3 v0;
    uint first;
    vec3 v1;
    uint turns;  // bits 0-2, 4-6: how A, B were turned against their own vertex order (see unturn); kLastBlock
    vec3 v2;
    uint pad0;
    vec3 v3;
    uint pad1;
};

CMPG_SHARED_END
#endif

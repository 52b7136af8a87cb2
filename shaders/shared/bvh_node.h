// The acceleration structure as the kernels read it: one array of 64-byte records (4 texels, one cache line), each a box node or a
// leaf block. A traversal step reads three texels of one record: reads cost far more than arithmetic on a CPU driver.
#ifndef CMPG_SHARED_BVH_NODE
#define CMPG_SHARED_BVH_NODE
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

CMPG_CONST kBvhWidth = 4;      // children of a box node
CMPG_CONST kMaxLeafBlocks = 4; // so a leaf holds at most 8 triangles
CMPG_CONST kMaxBvhDepth = 48;  // box nodes on a path from the root; the traversal stack holds as many entries
CMPG_CONST kMaxBvhRecords = 0x02000000u; // 2 GiB, the reach of a texel view; some 40 million triangles
// A child in BvhNode::children: bits 0-3 its record minus `base`, bits 4-6 its leaf blocks (0: a box node), bit 7 set. 0: no child.
CMPG_CONST kChildOffset = 0x0fu;
CMPG_CONST kChildBlocksShift = 4;
CMPG_CONST kChildBlocks = 7u;
CMPG_CONST kChildExists = 0x80u;

// Children's boxes in 8 bits a plane: plane = origin + byte * 2^(exponent - 127), rounded outwards. Byte c of each word belongs to
// child c. The records of all children stand side by side from `base` on.
struct BvhNode {
    vec3 origin;
    uint exponents; // x, y, z and the number of children, a byte each
    uvec3 low;
    uvec3 high;
    uint base;
    uint children;
    uvec4 unused;
};

// Two triangles that share the edge v0 v2: A = (v0, v1, v2) and B = (v0, v2, v3); a single triangle has v3 = v2.
// They are numbers `first` and `first + 1` in BVH order. Sharing saves a third of the reads and arithmetic.
struct LeafBlock {
    vec3 v0, v1, v2, v3;
    uint first;
    uint turns; // bits 0-2, 4-6: how A, B were turned against their own vertex order (see unturn)
    uvec2 unused;
};

CMPG_SHARED_END
#endif

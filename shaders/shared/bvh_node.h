// A node of the binary BVH: both children's boxes, so that one fetch decides where to go. 64 bytes = 4 texels = one cache line.
#ifndef CMPG_SHARED_BVH_NODE
#define CMPG_SHARED_BVH_NODE
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

CMPG_CONST kMaxLeafTriangles = 8;
CMPG_CONST kLeafBit = 0x80000000u; // in BvhNode::left/right: leaf, with (count << 27 | first triangle) in the other bits... see bvh.cpp
CMPG_CONST kMaxBvhDepth = 64;

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

CMPG_SHARED_END
#endif

// What the self-test of a device computes: src/vk/self_test.cpp knows the answers.
#ifndef CMPG_SHARED_SELF_TEST
#define CMPG_SHARED_SELF_TEST
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

CMPG_CONST kSelfTestItems = 293; // four workgroups and a part of one
CMPG_CONST kSelfTestInner = 31; // inner nodes of a complete binary tree, root first; its leaves follow
CMPG_CONST kSelfTestStack = 8;
CMPG_CONST kSelfTestPrepare = 0; // stage: writes the counts of items and groups of the other one
CMPG_CONST kSelfTestCompute = 1;

struct SelfTestPush {
    uint stage;
    uint items;
};

struct SelfTestCounts {
    uvec3 groups;
    uint items; // as the computing stage reads them from a uniform buffer
    uint places; // results written
    uint visits; // nodes visited by all items
};

// An item with an odd number of visits leaves one, wherever there is a place.
struct SelfTestResult {
    uint item;
    vec3 sum; // over the leaves visited: a vector times a number
    uint words; // over the same: exclusive or
    uint visits; // nodes
};

CMPG_SHARED_END
#endif

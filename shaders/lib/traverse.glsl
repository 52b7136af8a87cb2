// Closest-hit and any-hit traversal of Bvh::records. The including kernel includes lib/trace_queue.glsl, defines, before this file,
//     kAlphaMask, a bool constant, and, asked only with it, bool isCutOut(uint triangle, vec2 barycentrics, vec3 origin, vec3 direction)
// (shaders/scene/trace_masks.glsl), and drives rays by beginRay, walk and endRay. CMPG_ANY_HIT: a ray ends at the first hit.
//
// A step reads one record, of a box node or of a leaf block. Groups of children put aside stand in registers, each written and read by comparing its
// place with rayTop: a stack in an array costs a CPU driver a scattered access of memory for every step, and shifting the registers four selects of
// each instead of three. Trees too deep for kStack of them have the array (kStack = 0).
#include "shared/bindings.h"
#include "shared/bvh_node.h"
#include "shared/wavefront.h"
#include "lib/box.glsl"
#include "lib/read_buffers.glsl"

READ_UVEC4(nodeTexel, kBindNodes)

const uint kBlocksShift = 27u;      // in rayCursor: leaf blocks still to be tested, above the record's index; 0: a box node
const uint kRecordIndex = 0x07ffffffu;
const uint kPending = 0xfffffffeu; // in rayCursor: the next child is to be found
const int kMissed = 0x7fffffff;

vec3 rayOrigin, rayDirection, rayInverse;
vec3 rayAcross0, rayAcross1; // two directions the ray projects to zero in
float rayLimit;              // nearest hit so far
vec2 rayBarycentrics;        // of the block's triangle: weights of its second and third corner
uint rayBlock;               // record * 2 + (0: triangle A, 1: B) of that hit, or kNone
uint rayCursor;              // what to step at next, or kNone
uvec2 rayGroup;              // children of one node still to be visited: their base and a byte each, nearest first
uvec2 rayAside;              // group that a step made way for, to be put aside at its end; empty: none
// Groups put aside: in kStack registers, or in the array. Empty after rayTop of them.
uvec2 aside0, aside1, aside2, aside3, aside4, aside5, aside6, aside7, aside8, aside9, aside10, aside11;
uint rayTop;
uvec2 rayStack[kMaxBvhDepth];

uvec2 pick(bool condition, uvec2 yes, uvec2 no) { return mix(no, yes, bvec2(condition)); }

// Puts a group aside, or takes the last one back, or neither; returns the last one. Selects in the flow of the loop: in branches a CPU driver
// would select each register once for every level of them.
uvec2 moveStack(bool push, bool pop, uvec2 group) {
    uvec2 last = uvec2(0);
    if (kStack == 0u) {
        if (push)
            rayStack[rayTop] = group;
        if (pop && rayTop > 0u)
            last = rayStack[rayTop - 1u];
    }
    const uint place = push ? rayTop : kNone;
#define REGISTER(depth, aside) if (kStack > depth) last = pick(rayTop == depth + 1u, aside, last), aside = pick(place == depth, group, aside);
    REGISTER(0u, aside0) REGISTER(1u, aside1) REGISTER(2u, aside2) REGISTER(3u, aside3) REGISTER(4u, aside4) REGISTER(5u, aside5)
    REGISTER(6u, aside6) REGISTER(7u, aside7) REGISTER(8u, aside8) REGISTER(9u, aside9) REGISTER(10u, aside10) REGISTER(11u, aside11)
    rayTop += push ? 1u : pop ? ~0u : 0u; // below an empty stack the ray is done
    return last;
}

void beginRay(vec3 origin, vec3 direction, float limit) {
    rayOrigin = origin;
    rayDirection = direction;
    rayInverse = finiteInverse(direction);
    // Shear along the largest component (Woop, Benthin, Wald 2013): one product per corner, exact otherwise.
    const vec3 a = abs(direction);
    if (a.z >= max(a.x, a.y)) {
        rayAcross0 = vec3(1, 0, -direction.x / direction.z);
        rayAcross1 = vec3(0, 1, -direction.y / direction.z);
    } else if (a.y >= a.x) {
        rayAcross0 = vec3(0, -direction.z / direction.y, 1);
        rayAcross1 = vec3(1, -direction.x / direction.y, 0);
    } else {
        rayAcross0 = vec3(-direction.y / direction.x, 1, 0);
        rayAcross1 = vec3(-direction.z / direction.x, 0, 1);
    }
    rayLimit = limit;
    rayBlock = kNone;
    rayCursor = 0;
    rayGroup = uvec2(0);
    rayTop = 0u;
}

// The original corner order of a block's triangle: weights of its second and third vertex.
vec2 unturn(vec2 w12, uint turned) {
    const vec3 w = vec3(1.0 - w12.x - w12.y, w12);
    const uint turn = turned & 3u;
    // Corner i of the block is vertex (turn + i) mod 3, or (turn - i) mod 3 where the triangle runs the other way round.
    const uint second = (turned & 4u) == 0u ? (4u - turn) % 3u : (turn + 2u) % 3u;
    const uint third = (turned & 4u) == 0u ? (5u - turn) % 3u : (turn + 1u) % 3u;
    return vec2(w[second], w[third]);
}

// Number in BVH order and barycentrics of a block's triangle.
void identify(uint block, vec2 weights, out uint triangle, out vec2 barycentrics) {
    const uvec4 r3 = nodeTexel((block >> 1) * 4u + 3u);
    triangle = r3.x + (block & 1u);
    barycentrics = unturn(weights, r3.y >> (4u * (block & 1u)));
}

bool acceptBlock(uint block, vec2 weights) {
    if (!kAlphaMask)
        return true;
    uint triangle;
    vec2 barycentrics;
    identify(block, weights, triangle, barycentrics);
    return !isCutOut(triangle, barycentrics, rayOrigin, rayDirection);
}

// Normal of the triangle with these edges. The side is made perpendicular to the diagonal first: the product of a needle's nearly
// parallel edges would be mostly rounding.
vec3 normalOf(vec3 diagonal, vec3 along, vec3 side) { return cross(side - dot(side, along) * diagonal, diagonal); }

// Whether a hit of the triangle with these corner weights (not normalised) counts; then it becomes the nearest.
void tryTriangle(float w0, float w1, float w2, vec3 corner, vec3 normal, uint block) {
    const float sum = w0 + w1 + w2; // 0: edge on
    const bool inside = sum != 0.0 && ((w0 >= 0.0 && w1 >= 0.0 && w2 >= 0.0) || (w0 <= 0.0 && w1 <= 0.0 && w2 <= 0.0));
    const float t = dot(corner, normal) / dot(rayDirection, normal);
    const vec2 weights = vec2(w1, w2) / sum;
    if (inside && t > 0.0 && t < rayLimit && acceptBlock(block, weights)) {
        rayLimit = t;
        rayBarycentrics = weights;
        rayBlock = block;
    }
}

// The nearest child of the group that is still to be visited, and takes it out; kNone where there is none.
uint takeChild(inout uvec2 group) {
    const uint child = group.y & 0xffu;
    const uint cursor = (group.x + (child & kChildOffset)) | ((child >> kChildBlocksShift & kChildBlocks) << kBlocksShift);
    group.y >>= 8;
    return child == 0u ? kNone : cursor;
}

bool atNode() { return rayCursor <= kRecordIndex; }
bool atLeaf() { return rayCursor > kRecordIndex && rayCursor < kPending; }

// Entry distance into child c with c in its two lowest bits, or kMissed. Distances are compared as integers: the same order for
// values >= 0, and a negative value stays below them, which is all a slab test needs; lavapipe spends one instruction on it where a
// float minimum takes three.
int enterChild(uint c, uint count, uvec3 nearPlanes, uvec3 farPlanes, vec3 scale, vec3 nearShift, vec3 farShift) {
    const uvec3 nearByte = nearPlanes >> (8u * c) & 0xffu, farByte = farPlanes >> (8u * c) & 0xffu;
    const ivec3 near = floatBitsToInt(vec3(nearByte) * scale + nearShift), far = floatBitsToInt(vec3(farByte) * scale + farShift);
    const int entry = max(max(near.x, near.y), max(near.z, 0));
    const int leave = min(min(far.x, far.y), min(far.z, floatBitsToInt(rayLimit)));
    // 8 units in the last place cover the roundings that are relative to the distance.
    return c < count && entry <= leave + 8 ? (entry & ~3) | int(c) : kMissed;
}

uint childByte(int key, uint children) { return key == kMissed ? 0u : children >> (8u * (uint(key) & 3u)) & 0xffu; }

void stepNode() {
    const uvec4 r0 = nodeTexel(rayCursor * 4u), r1 = nodeTexel(rayCursor * 4u + 1u), r2 = nodeTexel(rayCursor * 4u + 2u);
    const uvec3 low = r1.xyz, high = uvec3(r1.w, r2.xy);
    const vec3 scale = uintBitsToFloat(uvec3(r0.w << 23 & 0x7f800000u, r0.w << 15 & 0x7f800000u, r0.w << 7 & 0x7f800000u)) * rayInverse;
    const vec3 shift = (uintBitsToFloat(r0.xyz) - rayOrigin) * rayInverse;
    // Rounding of shift, and of the sum's cancellation against it.
    const vec3 slack = abs(shift) * 4e-7;
    const bvec3 backwards = lessThan(rayInverse, vec3(0));
    const uvec3 nearPlanes = mix(low, high, backwards), farPlanes = mix(high, low, backwards);
    const vec3 nearShift = shift - slack, farShift = shift + slack;
    const uint count = r0.w >> 24;
    const int k0 = enterChild(0u, count, nearPlanes, farPlanes, scale, nearShift, farShift);
    const int k1 = enterChild(1u, count, nearPlanes, farPlanes, scale, nearShift, farShift);
    const int k2 = enterChild(2u, count, nearPlanes, farPlanes, scale, nearShift, farShift);
    const int k3 = enterChild(3u, count, nearPlanes, farPlanes, scale, nearShift, farShift);
    const int a0 = min(k0, k1), a1 = max(k0, k1), a2 = min(k2, k3), a3 = max(k2, k3);
    const int b1 = max(a0, a2), b2 = min(a1, a3);
    const uint group = childByte(min(a0, a2), r2.w) | childByte(min(b1, b2), r2.w) << 8 | childByte(max(b1, b2), r2.w) << 16 |
                       childByte(max(a1, a3), r2.w) << 24;
    if (group != 0u) {
        rayAside = rayGroup;
        rayGroup = uvec2(r2.z, group);
    }
    rayCursor = rayGroup.y == 0u ? kPending : takeChild(rayGroup);
}

void stepLeaf() {
    const uint index = rayCursor & kRecordIndex;
    const uvec4 r0 = nodeTexel(index * 4u), r1 = nodeTexel(index * 4u + 1u), r2 = nodeTexel(index * 4u + 2u);
    const vec3 q0 = uintBitsToFloat(r0.xyz) - rayOrigin, q1 = uintBitsToFloat(uvec3(r0.w, r1.xy)) - rayOrigin;
    const vec3 q2 = uintBitsToFloat(uvec3(r1.zw, r2.x)) - rayOrigin, q3 = uintBitsToFloat(r2.yzw) - rayOrigin;
    // Corners projected along the ray; an edge's term depends on its two corners alone and changes only its sign with
    // their order, so rays cannot slip between triangles that share corners.
    const vec2 c0 = vec2(dot(q0, rayAcross0), dot(q0, rayAcross1)), c1 = vec2(dot(q1, rayAcross0), dot(q1, rayAcross1));
    const vec2 c2 = vec2(dot(q2, rayAcross0), dot(q2, rayAcross1)), c3 = vec2(dot(q3, rayAcross0), dot(q3, rayAcross1));
    precise const float e01 = c0.x * c1.y - c0.y * c1.x, e12 = c1.x * c2.y - c1.y * c2.x, e20 = c2.x * c0.y - c2.y * c0.x;
    precise const float e23 = c2.x * c3.y - c2.y * c3.x, e30 = c3.x * c0.y - c3.y * c0.x;
    const vec3 diagonal = q2 - q0;
    const vec3 along = diagonal / dot(diagonal, diagonal);
    tryTriangle(e12, e20, e01, q0, normalOf(diagonal, along, q1 - q0), index * 2u);
    tryTriangle(e23, e30, -e20, q0, normalOf(diagonal, along, q3 - q0), index * 2u + 1u);
#ifdef CMPG_ANY_HIT
    if (rayBlock != kNone) {
        rayCursor = kNone;
        return;
    }
#endif
    rayCursor += 1u - (1u << kBlocksShift);
    if (atNode())
        rayCursor = kPending;
}

// Goes to the nearest child that is still to be visited, of the last group that has one.
void advance() {
    const bool next = rayCursor == kPending, put = rayAside.y != 0u;
    const bool empty = next && rayGroup.y == 0u;
    const uvec2 last = moveStack(put && !empty, empty && !put, rayAside);
    rayGroup = pick(empty, pick(put, rayAside, last), rayGroup);
    if (next)
        rayCursor = takeChild(rayGroup);
}

// Steps until the ray has ended. True: it was given up, because it met too many records.
// One loop for both kinds of records: lanes at a node and lanes at a leaf wait for each other, which on CPU drivers costs less than votes on
// which kind is next.
bool walk() {
    uint steps = 0u;
    while (rayCursor != kNone && steps < kMaxSteps) {
        rayAside = uvec2(0);
        if (atNode())
            stepNode();
        if (atLeaf())
            stepLeaf();
        advance();
        ++steps;
    }
    return rayCursor != kNone;
}

// Weights of the second and third corner at a point of the triangle: along the longest edge first, then across it. On a needle the
// intersection test's own weights are mostly rounding; these lead to the point even where its place across is lost.
vec2 weightsAt(vec3 a, vec3 b, vec3 c, vec3 point) {
    const vec3 ab = b - a, bc = c - b, ca = a - c;
    const float lab = dot(ab, ab), lbc = dot(bc, bc), lca = dot(ca, ca);
    const uint first = lab >= max(lbc, lca) ? 0u : lbc >= lca ? 1u : 2u; // corner the longest edge starts from
    const vec3 start = first == 0u ? a : first == 1u ? b : c, edge = first == 0u ? ab : first == 1u ? bc : ca;
    const vec3 side = first == 0u ? -ca : first == 1u ? -ab : -bc; // from there to the third corner
    const float scale = 1.0 / max(lab, max(lbc, lca));
    const float foot = dot(side, edge) * scale, along = dot(point - start, edge) * scale;
    const vec3 across = side - foot * edge;
    const float third = clamp(dot(point - start - along * edge, across) / max(dot(across, across), 1e-37), 0.0, 1.0);
    const float second = along - third * foot; // beyond the end of a needle so thin that the test let it be met there
    const float rest = 1.0 - second - third;
    return first == 0u ? vec2(second, third) : first == 1u ? vec2(rest, second) : vec2(third, rest);
}

Hit endRay() {
    Hit hit = Hit(-1.0, kNone, vec2(0));
    if (rayBlock != kNone) {
        hit.t = rayLimit;
        const uint at = (rayBlock >> 1) * 4u;
        const uvec4 r0 = nodeTexel(at), r1 = nodeTexel(at + 1u), r2 = nodeTexel(at + 2u);
        const vec3 q0 = uintBitsToFloat(r0.xyz) - rayOrigin, q2 = uintBitsToFloat(uvec3(r1.zw, r2.x)) - rayOrigin;
        const vec3 q1 = uintBitsToFloat(uvec3(r0.w, r1.xy)) - rayOrigin, q3 = uintBitsToFloat(r2.yzw) - rayOrigin;
        const bool other = (rayBlock & 1u) != 0u;
        const vec2 weights = weightsAt(q0, other ? q2 : q1, other ? q3 : q2, rayLimit * rayDirection);
        identify(rayBlock, weights, hit.triangle, hit.barycentrics);
    }
    return hit;
}

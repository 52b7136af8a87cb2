// Closest-hit and any-hit traversal of Bvh::nodes. The including kernel defines, before this file,
//     bool acceptHit(uint triangle, vec2 barycentrics)   // false: the triangle is cut out here (alpha mask)
// and drives a ray by beginRay, stepRay while the cursor is not kNone, and endRay.
//
// One step reads one record, a box node or a leaf block, and does the arithmetic of both kinds: on a CPU driver the reads
// cost several times the arithmetic, and no lane waits for lanes that are at the other kind.
#include "shared/bindings.h"
#include "shared/bvh_node.h"
#include "shared/wavefront.h"
#include "lib/read_buffers.glsl"

READ_UVEC4(nodeTexel, kBindNodes)

vec3 rayOrigin, rayDirection, rayInverse;
vec3 rayAcross0, rayAcross1; // two directions the ray projects to zero in
float rayLimit;              // nearest hit so far
vec2 rayBarycentrics;        // of the block's triangle: weights of its second and third corner
uint rayBlock;               // block * 2 + (0: triangle A, 1: B) of that hit, or kNone
uint rayCursor;              // record to be read next, or kNone
uint rayTop;
uint rayStack[kMaxBvhDepth + 1];

void beginRay(vec3 origin, vec3 direction, float limit) {
    rayOrigin = origin;
    rayDirection = direction;
    // Keeps the inverse finite: a box plane through the origin then gives 0, not NaN.
    const vec3 tiny = vec3(1e-20);
    rayInverse = 1.0 / mix(direction, mix(tiny, -tiny, lessThan(direction, vec3(0))), lessThan(abs(direction), tiny));
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
    rayTop = 0;
    rayStack[0] = kNone;
}

// Ordered as integers: the same for values >= 0, and a negative value stays below them, which is all the slab test needs; lavapipe
// spends one instruction on it where a float minimum takes three.
int minBits(int a, int b) { return min(a, b); }

bool meetsBox(vec3 low, vec3 high, out int entry) {
    const ivec3 t0 = floatBitsToInt((low - rayOrigin) * rayInverse), t1 = floatBitsToInt((high - rayOrigin) * rayInverse);
    const ivec3 near = min(t0, t1), far = max(t0, t1);
    entry = max(max(near.x, near.y), max(near.z, 0));
    // 4 units in the last place cover the rounding of both products (Ize 2013).
    const int leave = min(min(far.x, far.y), min(far.z, floatBitsToInt(rayLimit)));
    return entry <= leave + 8;
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

// Whether a hit of the triangle with these corner weights (not normalised) counts; then it becomes the nearest.
void tryTriangle(bool possible, float w0, float w1, float w2, float z0, float z1, float z2, uint block, uint first, uint turned) {
    const bool inside = min(min(w0, w1), w2) >= 0.0 || max(max(w0, w1), w2) <= 0.0;
    const float scale = 1.0 / (w0 + w1 + w2);
    const float t = (w0 * z0 + w1 * z1 + w2 * z2) * scale;
    const vec2 weights = vec2(w1, w2) * scale;
    // An infinite scale (edge on) gives a t that fails the comparison.
    if (possible && inside && t > 0.0 && t < rayLimit && acceptHit(first + (block & 1u), unturn(weights, turned))) {
        rayLimit = t;
        rayBarycentrics = weights;
        rayBlock = block;
    }
}

void stepRay() {
    const bool leaf = (rayCursor & kLeafBit) != 0u;
    const uint index = rayCursor & ~kLeafBit;
    const uvec4 r0 = nodeTexel(index * 4u), r1 = nodeTexel(index * 4u + 1u), r2 = nodeTexel(index * 4u + 2u), r3 = nodeTexel(index * 4u + 3u);
    const vec3 p0 = uintBitsToFloat(r0.xyz), p1 = uintBitsToFloat(r1.xyz), p2 = uintBitsToFloat(r2.xyz), p3 = uintBitsToFloat(r3.xyz);

    // Leaf block. Corners projected along the ray; an edge's term depends on its two corners alone and changes only its sign with
    // their order, so rays cannot slip between triangles that share corners.
    const vec3 q0 = p0 - rayOrigin, q1 = p1 - rayOrigin, q2 = p2 - rayOrigin, q3 = p3 - rayOrigin;
    const vec2 c0 = vec2(dot(q0, rayAcross0), dot(q0, rayAcross1)), c1 = vec2(dot(q1, rayAcross0), dot(q1, rayAcross1));
    const vec2 c2 = vec2(dot(q2, rayAcross0), dot(q2, rayAcross1)), c3 = vec2(dot(q3, rayAcross0), dot(q3, rayAcross1));
    const float z0 = dot(q0, rayDirection), z1 = dot(q1, rayDirection), z2 = dot(q2, rayDirection), z3 = dot(q3, rayDirection);
    precise const float e01 = c0.x * c1.y - c0.y * c1.x, e12 = c1.x * c2.y - c1.y * c2.x, e20 = c2.x * c0.y - c2.y * c0.x;
    precise const float e23 = c2.x * c3.y - c2.y * c3.x, e30 = c3.x * c0.y - c3.y * c0.x;
    tryTriangle(leaf, e12, e20, e01, z0, z1, z2, index * 2u, r0.w, r1.w);
    tryTriangle(leaf, e23, e30, -e20, z0, z2, z3, index * 2u + 1u, r0.w, r1.w >> 4);

    // Box node: the nearer child next, the other one kept for later.
    int leftEntry, rightEntry;
    const bool left = meetsBox(p0, p1, leftEntry), right = meetsBox(p2, p3, rightEntry);
    const bool leftNext = left && (!right || leftEntry <= rightEntry);
    if (!leaf && left && right) {
        ++rayTop;
        rayStack[rayTop] = leftNext ? r1.w : r0.w;
    }
    const bool pop = leaf ? (r1.w & kLastBlock) != 0u : !(left || right);
#ifdef CMPG_ANY_HIT
    if (rayBlock != kNone)
        rayCursor = kNone;
    else
#endif
    if (pop) {
        rayCursor = rayStack[rayTop];
        --rayTop;
    } else {
        rayCursor = leaf ? rayCursor + 1u : (leftNext ? r0.w : r1.w);
    }
}

Hit endRay() {
    if (rayBlock == kNone)
        return Hit(-1.0, kNone, vec2(0));
    const uint base = (rayBlock >> 1) * 4u, which = rayBlock & 1u;
    const uint first = nodeTexel(base).w, turned = nodeTexel(base + 1u).w >> (4u * which);
    return Hit(rayLimit, first + which, unturn(rayBarycentrics, turned));
}

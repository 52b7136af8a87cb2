// The guide: the cell a point lies in, and directions drawn from the mixture of its distributions (Fan et al. 2024).
//
// The includer defines how the published tree is read:
//     uint guideSpatialWord(uint word)                    see shared/guide.h
//     uvec4 guideNode(uint node)                          see shared/guide.h
#ifndef CMPG_LIB_GUIDE
#define CMPG_LIB_GUIDE
#include "lib/guide_mixture.glsl"
#include "lib/math.glsl"
#include "shared/guide.h"

const float kBelowOne = 0.99999994;
const float kPointStep = 5.9604645e-8; // 2^-24, to which points of the square are exact

// Equal-area map of the sphere to the unit square: azimuth / 2 pi, (1 + z) / 2.
vec2 squareFromDirection(vec3 d) {
    float x = atan(d.y, d.x == 0.0 ? 1e-30 : d.x) * (0.5 * kInvPi); // GLSL has no atan(0, 0)
    if (x < 0.0) x += 1.0;
    return clamp(vec2(x, 0.5 + 0.5 * d.z), vec2(0.0), vec2(kBelowOne));
}

vec3 directionFromSquare(vec2 s) {
    vec2 on = 2.0 * sqrt(max(s.y * (1.0 - s.y), 0.0)) * unitCircle(s.x); // keeps its relative accuracy at the poles
    return normalize(vec3(on.x, on.y, 2.0 * s.y - 1.0));
}

// `t`: position in the tree's box, [0,1)^3.
uint guideCellAt(vec3 t) {
    // The highest of these bits are the sides of the first level. Exact: float and integer hold all of them.
    uvec3 sides = uvec3(clamp(t, vec3(0.0), vec3(kBelowOne)) * float(1 << kMaxSpatialLevels));
    uint word = 0u;
    for (uint level = kMaxSpatialLevels; level-- > 0u;) {
        uvec3 side = sides >> level & 1u;
        word = guideSpatialWord(word + side.x + 2u * side.y + 4u * side.z);
        if ((word & kSpatialLeaf) != 0u) break;
    }
    return word & ~kSpatialLeaf;
}

struct GuideWalk {
    vec2 point;    // of the unit square
    float density; // per steradian; 0 where the mixture has no mass
    uint leaf;     // quadrant the walk ended in
};

// Child of a node in a quadrant; 0: none.
uint guideChild(uvec4 node, uint quadrant) {
    uint before = node.w & ((1u << quadrant) - 1u);
    return (node.w >> quadrant & 1u) != 0u ? (node.w >> kQuadChildBits) + uint(bitCount(before)) : 0u;
}

// One of the three fractions in a word, in units of 1 / kQuadFractionOne.
int guideFraction(uint splits, uint index) { return int(splits >> (index * kQuadFractionBits) & kQuadFractionOne); }

// The share of a node's mass that lies in a quadrant.
float guideQuadrantShare(uint splits, bool right, bool top) {
    int left = guideFraction(splits, 0u);
    int below = guideFraction(splits, right ? 2u : 1u);
    return float(right ? int(kQuadFractionOne) - left : left) * float(top ? int(kQuadFractionOne) - below : below) *
           (1.0 / float(kQuadFractionOne * kQuadFractionOne));
}

// Those of P, D+, D-.
vec3 guideQuadrantShares(uvec4 node, bool right, bool top) {
    return vec3(guideQuadrantShare(node.x, right, top), guideQuadrantShare(node.y, right, top), guideQuadrantShare(node.z, right, top));
}

// One walk from the root of a cell's quadtree to a leaf: draws a point of `part` from the random numbers `at`, or follows the point `at`,
// and evaluates the whole mixture there. `parts`: see guideParts().
GuideWalk guideWalk(uint root, vec3 parts, bool draw, uint part, vec2 at) {
    GuideWalk walk;
    vec2 corner = vec2(0.0);
    float edge = 1.0;
    vec3 densities = parts; // on the unit square
    uint index = root;
    for (uint depth = 0u; depth <= kMaxQuadDepth; ++depth) {
        uvec4 node = guideNode(index);
        uint splits = part == 0u ? node.x : part == 1u ? node.y : node.z;
        // The split of each axis: by mass when drawing, in the middle when following.
        float splitX = draw ? float(guideFraction(splits, 0u)) * (1.0 / float(kQuadFractionOne)) : 0.5;
        bool right = at.x >= splitX;
        float splitY = draw ? float(guideFraction(splits, right ? 2u : 1u)) * (1.0 / float(kQuadFractionOne)) : 0.5;
        bool top = at.y >= splitY;
        at.x = min((right ? at.x - splitX : at.x) / (right ? 1.0 - splitX : splitX), kBelowOne);
        at.y = min((top ? at.y - splitY : at.y) / (top ? 1.0 - splitY : splitY), kBelowOne);
        edge *= 0.5;
        corner += edge * vec2(right ? 1.0 : 0.0, top ? 1.0 : 0.0);
        densities *= 4.0 * guideQuadrantShares(node, right, top);
        uint quadrant = (right ? 1u : 0u) + (top ? 2u : 0u);
        walk.leaf = 4u * index + quadrant;
        index = guideChild(node, quadrant);
        if (index == 0u) break;
    }
    walk.point = min(corner + edge * at, corner + (edge - kPointStep)); // exact: rounding must not carry it into the next quadrant
    walk.density = (densities.x + densities.y + densities.z) * (0.25 * kInvPi);
    return walk;
}

// The density alone.
float guideDensity(uint root, vec3 parts, vec2 point) {
    vec3 densities = parts;
    vec2 at = point;
    uint index = root;
    for (uint depth = 0u; depth <= kMaxQuadDepth; ++depth) {
        uvec4 node = guideNode(index);
        at = 2.0 * at;
        bool right = at.x >= 1.0;
        bool top = at.y >= 1.0;
        at -= vec2(right ? 1.0 : 0.0, top ? 1.0 : 0.0);
        densities *= 4.0 * guideQuadrantShares(node, right, top);
        index = guideChild(node, (right ? 1u : 0u) + (top ? 2u : 0u));
        if (index == 0u) break;
    }
    return (densities.x + densities.y + densities.z) * (0.25 * kInvPi);
}

#endif

// The guide as the kernels read it (published means) and write it (records): one cell per leaf of the spatial tree, one quadtree a cell.
#ifndef CMPG_SHARED_GUIDE
#define CMPG_SHARED_GUIDE
#include "shared/prelude.h"
CMPG_SHARED_BEGIN

// Spatial nodes, a word for each octant of their box, the root first: the first word of the octant's own node, or kSpatialLeaf | cell. Octants have the
// number (x >= middle) + 2 (y >= middle) + 4 (z >= middle).
CMPG_CONST kSpatialLeaf = 0x80000000u;
CMPG_CONST kSpatialChildren = 8;
CMPG_CONST kMaxSpatialDepth = 40; // splits, of one axis each
CMPG_CONST kMaxSpatialLevels = (kMaxSpatialDepth + 2u) / 3u; // nodes on the way to a cell
CMPG_CONST kMaxQuadDepth = 10;

// A cell: two uvec4 texels.
struct GpuGuideCell {
    uint root; // first quadtree node
    float reflected, derivative; // means of R and of the L1 norm of T, light sampling included
    uint unused;
    vec3 total; // means of P, D+, D- over the sphere, as the quadrants': in a unit of the cell's own
    uint unused2;
};
CMPG_CONST kGuideCellTexels = 2;

// A quadtree node is one uvec4 texel. x, y, z: how the mass of P, D+, D- splits, three fractions in units of 1 / kQuadFractionOne, the
// first in the lowest bits: left of the middle, then below the middle on the left and on the right. w: its children, which lie side by
// side: the first << 4 | a bit for each quadrant that has one. Quadrants have the number (x >= middle) + 2 (y >= middle).
CMPG_CONST kQuadFractionBits = 10;
CMPG_CONST kQuadFractionOne = 1023;
CMPG_CONST kQuadChildBits = 4;

// A sum as a 64-bit integer; two words where nobody adds to it. scene/integer_sums.glsl, if included, comes first.
#ifndef INTEGER_SUM
#define INTEGER_SUM uvec2
#endif

// Records of one quadrant: sums of P, D+, D-.
struct GuideLeafSums {
    INTEGER_SUM primal, plus, minus;
};
// Records of one cell.
struct GuideCellSums {
    INTEGER_SUM reflected, derivative;
    uint count, unused;
};

// What a vertex left for the backward scan: where its drawn direction ended.
struct GuideVisit {
    uint leaf; // node * 4 + quadrant; kNone: a material too smooth to be guided, whose light is nobody else's
    uint cell; // kNone: nothing was drawn
};

// How a pass is guided.
struct GuideInfo {
    vec3 lower; // of the spatial tree's box
    uint kind; // kGuide...
    vec3 inverseExtent;
    float share; // of guided directions where the guide knows something
    vec2 primalScale, derivativeScale; // records are integers in units of 2^-k; x y = 2^k
    float reference; // roulette: expected derivative contribution of a camera path, adjoint included
};
CMPG_CONST kGuideNone = 0; // nothing is drawn from the guide
CMPG_CONST kGuidePrimal = 1;
CMPG_CONST kGuideDifferential = 2;
CMPG_CONST kGuideUniform = 3;
CMPG_CONST kGuideConditional = 4;
CMPG_CONST kDefensiveParts = 4; // of the conditional mixture, P has one at least: guideDefended()

CMPG_SHARED_END
#endif

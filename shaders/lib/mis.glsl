// Multiple importance sampling of two techniques.
#ifndef CMPG_LIB_MIS
#define CMPG_LIB_MIS
#include "lib/dual.glsl"

// Power heuristic with exponent 2 for a sample drawn with density `own` that the other technique would draw with density `other`.
// Formed from the ratio, so that squares cannot overflow. own = 0 gives 0, other = 0 gives 1, two infinite densities share.
float misWeight(float own, float other) {
    if (!(own > 0.0)) return 0.0;
    if (own == other) return 0.5;
    float ratio = other / own;
    return 1.0 / (1.0 + ratio * ratio);
}

#endif

// Maps from the unit square to shapes with a given density.
#ifndef CMPG_LIB_WARP
#define CMPG_LIB_WARP
#include "lib/math.glsl"

// Upper hemisphere about z with density cos / pi per steradian.
vec3 sampleCosineHemisphere(vec2 u) {
    vec2 on = sqrt(u.x) * unitCircle(u.y);
    return vec3(on.x, on.y, safeSqrt(1.0 - u.x));
}

// Weights of the second and third vertex of a point uniform on a triangle. Folds the square along its diagonal, which keeps
// strata whole (Heitz 2019, "A Low-Distortion Map Between Triangle and Square", section 3).
vec2 sampleTriangle(vec2 u) {
    if (u.y > u.x) return vec2(0.5 * u.x, u.y - 0.5 * u.x);
    return vec2(u.x - 0.5 * u.y, 0.5 * u.y);
}

// A number from 0 to 1 with density in proportion to mix(a, b, x): the inverse of its cumulative, without cancellation. a, b from 0.1 to
// 10 or so: squares must not vanish.
float sampleLinear(float u, float a, float b) {
    return min(u * (a + b) / (a + sqrt(mix(a * a, b * b, u))), 1.0);
}

#endif

// Where a new ray starts, so that it does not meet the surface it leaves.
#ifndef CMPG_LIB_RAY_OFFSET
#define CMPG_LIB_RAY_OFFSET
#include "lib/dual.glsl"

// In units of the largest coordinate that made the hit point. Interpolating a point of a triangle in float misses the plane by up to
// some 4 ulp = 5e-7 of it; the rest is margin for the intersection test's own rounding.
const float kRayOffset = 2e-6;

float largestCoordinate(vec3 v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); }

// The hit point moved along the geometric normal to the side the ray goes to. magnitude: the largest absolute coordinate of the
// triangle's vertices (the hit point's own may be near 0 while its error is not).
vec3 offsetRayOrigin(vec3 point, vec3 geometricNormal, vec3 direction, float magnitude) {
    float side = dot(geometricNormal, direction) < 0.0 ? -1.0 : 1.0;
    return point + geometricNormal * (side * kRayOffset * magnitude);
}

#endif

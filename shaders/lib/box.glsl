// Whether a ray crosses a box.
#ifndef CMPG_LIB_BOX
#define CMPG_LIB_BOX
#include "lib/dual.glsl"

// 1 / direction, finite: a box plane through a ray's origin then gives 0, not NaN.
vec3 finiteInverse(vec3 direction) {
    const vec3 tiny = vec3(1e-20);
    return 1.0 / mix(direction, mix(tiny, -tiny, lessThan(direction, vec3(0))), lessThan(abs(direction), tiny));
}

// `direction` need not be of unit length. No ray crosses a box with low > high.
bool crossesBox(vec3 origin, vec3 direction, vec3 low, vec3 high) {
    const vec3 inverse = finiteInverse(direction);
    const vec3 toLow = (low - origin) * inverse, toHigh = (high - origin) * inverse;
    const bvec3 backward = lessThan(inverse, vec3(0));
    const vec3 entry = mix(toLow, toHigh, backward), leave = mix(toHigh, toLow, backward);
    const float end = min(leave.x, min(leave.y, leave.z));
    return end >= 0.0 && max(entry.x, max(entry.y, entry.z)) <= end;
}

#endif

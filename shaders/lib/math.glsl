// Constants, frames and products that keep their relative accuracy.
#ifndef CMPG_LIB_MATH
#define CMPG_LIB_MATH
#include "lib/dual.glsl"

const float kPi = 3.14159265358979323846;
const float kInvPi = 0.31830988618379067154;

// Cosines up to this size count as zero: far below what the dot product of two float unit vectors resolves.
const float kMinCosine = 1e-9;

float square(float x) { return x * x; }
float maxComponent(vec3 v) { return max(v.x, max(v.y, v.z)); }
// sqrt(a^2 + b^2) of numbers >= 0, and a length: squares neither overflow nor vanish.
float rootSum(float a, float b) {
    float larger = max(a, b);
    float ratio = min(a, b) / max(larger, 1e-37);
    return larger * sqrt(1.0 + ratio * ratio);
}
float safeLength(vec3 v) {
    float largest = maxComponent(abs(v));
    return largest * length(v / max(largest, 1e-37));
}
float safeSqrt(float x) { return sqrt(max(x, 0.0)); }

// Cosine and sine of 2 pi turn, turn in [0, 1]: GLSL's promise nothing beyond [-pi, pi], so half a turn is taken off and put back.
vec2 unitCircle(float turn) {
    float phi = 2.0 * kPi * (turn - 0.5);
    return vec2(-cos(phi), -sin(phi));
}

// sin(x) for x in [0, pi/2], to 1e-7 of itself. Vulkan lets sin() be off by 2^-11, and drivers use that: of a small angle nothing may
// be left. The series' next term is 6e-8.
float accurateSin(float x) {
    float y = x * x;
    return x * (1.0 - y / 6.0 * (1.0 - y / 20.0 * (1.0 - y / 42.0 * (1.0 - y / 72.0 * (1.0 - y / 110.0)))));
}

// Two unit vectors that make a right-handed frame (x, y, n) with the unit vector n.
// Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
void orthonormalFrame(vec3 n, OUT(vec3) x, OUT(vec3) y) {
    float s = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    x = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    y = vec3(b, s + n.y * n.y * a, -n.y);
}

// What a + b loses to rounding (Knuth's two-sum).
vec3 sumError(vec3 a, vec3 b) {
    PRECISE vec3 s = a + b;
    PRECISE vec3 fromB = s - a;
    PRECISE vec3 error = (a - (s - fromB)) + (b - fromB);
    return error;
}

// The leading 12 bits of each component (Veltkamp's split for float; in double it merely splits elsewhere).
vec3 leadingBits(vec3 v) {
    PRECISE vec3 scaled = v * 4097.0;
    PRECISE vec3 high = scaled - (scaled - v);
    return high;
}

// Dot product whose error is about 2^-36 |a| |b| instead of 2^-24: a cosine keeps its relative accuracy where vectors are nearly
// perpendicular.
float accurateDot(vec3 a, vec3 b) {
    vec3 ah = leadingBits(a);
    vec3 bh = leadingBits(b);
    PRECISE vec3 p = ah * bh; // exact
    PRECISE float xy = p.x + p.y;
    PRECISE float fromY = xy - p.x;
    PRECISE float all = xy + p.z;
    PRECISE float fromZ = all - xy;
    PRECISE float lost = ((p.x - (xy - fromY)) + (p.y - fromY)) + ((xy - (all - fromZ)) + (p.z - fromZ));
    return all + (lost + (dot(ah, b - bh) + dot(a - ah, b)));
}

// Cross product whose error is about 2^-36 |a| |b| instead of 2^-24: products of the leading halves are exact and so are their
// differences where they cancel. The angle between nearly parallel vectors keeps its relative accuracy.
vec3 accurateCross(vec3 a, vec3 b) {
    vec3 ah = leadingBits(a);
    vec3 bh = leadingBits(b);
    vec3 al = a - ah;
    vec3 bl = b - bh;
    // PRECISE: without it lavapipe regroups these products and the result is no better than cross().
    PRECISE vec3 leading = vec3(ah.y * bh.z - ah.z * bh.y, ah.z * bh.x - ah.x * bh.z, ah.x * bh.y - ah.y * bh.x);
    return leading + (cross(ah, bl) + cross(al, b));
}

#endif

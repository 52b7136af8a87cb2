// Numbers whose sum does not depend on the order: signed 64-bit integers as two words, made without 64-bit arithmetic.
#ifndef CMPG_LIB_FIXED_POINT
#define CMPG_LIB_FIXED_POINT
#include "lib/dual.glsl"

const float kFixedPointLimit = 4611686018427387904.0; // 2^62: one more bit for the first sum, the rest is the scale's business

// round(x * scale) in two's complement, low word first; scale is a power of two, so nothing but that rounding (to nearest, ties to
// even) happens. False: saturated at the limit, or 0 for what is not a number; the caller counts it.
bool toFixedPoint(float x, float scale, OUT(uvec2) words) {
    float y = abs(x) * scale;
    bool fits = y < kFixedPointLimit;
    if (!fits) y = y >= kFixedPointLimit ? kFixedPointLimit : 0.0;
    if (y < 8388608.0) y = roundEven(y); // from 2^23 on a float is a whole number
    float high = floor(y * (1.0 / 4294967296.0));
    words = uvec2(uint(y - high * 4294967296.0), uint(high));
    if (x < 0.0) words = uvec2(0u - words.x, words.x == 0u ? 0u - words.y : ~words.y);
    return fits;
}

#endif

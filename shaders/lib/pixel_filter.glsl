// Reconstruction filters as distributions of a pixel's samples: where a sample lies is drawn in proportion to the filter, so each belongs to one pixel and
// weighs 1 (filter importance sampling; Ernst, Stamminger and Greiner 2006). Filters are separable; along an axis, from the middle of the pixel:
//   tent      1 - |x| / radius
//   gaussian  exp(-x^2 / (2 deviation^2)) - exp(-radius^2 / (2 deviation^2))
#ifndef CMPG_LIB_PIXEL_FILTER
#define CMPG_LIB_PIXEL_FILTER
#include "lib/math.glsl"
#include "shared/batch.h"

// Of the gaussian from 0 to x, |x| <= radius, and its value there. The error function is Abramowitz and Stegun's 7.1.26 (1964), within 1.5e-7.
float gaussianIntegral(float radius, float deviation, float x, OUT(float) value) {
    float edge = exp(-radius * radius / (2.0 * deviation * deviation));
    float a = abs(x) / (deviation * 1.4142135624);
    float bell = exp(-a * a);
    float t = 1.0 / (1.0 + 0.3275911 * a);
    float beyond = ((((1.061405429 * t - 1.453152027) * t + 1.421413741) * t - 0.284496736) * t + 0.254829592) * t * bell;
    value = bell - edge;
    return deviation * 1.2533141373 * (x < 0.0 ? beyond - 1.0 : 1.0 - beyond) - edge * x; // sqrt(pi / 2)
}

float tentOffset(float radius, float low, float high, float u) {
    float first = low - low * abs(low) / (2.0 * radius);
    float last = high - high * abs(high) / (2.0 * radius);
    float target = first + u * (last - first);
    // The smaller root of x - x^2 / (2 radius) = |target|, without cancellation.
    float x = 2.0 * abs(target) / (1.0 + safeSqrt(1.0 - 2.0 * abs(target) / radius));
    return clamp(target < 0.0 ? -x : x, low, high);
}

// Newton's method, within a bracket that is halved where a step would leave it: where the filter falls to 0 steps overshoot.
float gaussianOffset(float radius, float deviation, float low, float high, float u) {
    float value;
    float first = gaussianIntegral(radius, deviation, low, value);
    float target = first + u * (gaussianIntegral(radius, deviation, high, value) - first);
    float x = clamp(target, low, high);
    float step = high - low;
    for (uint i = 0u; i < 22u && abs(step) > 3e-5 * radius; ++i) { // the next step is far smaller
        float excess = gaussianIntegral(radius, deviation, x, value) - target;
        low = excess > 0.0 ? low : x;
        high = excess > 0.0 ? x : high;
        float next = x - excess / max(value, 1e-6);
        next = next >= low && next <= high ? next : 0.5 * (low + high);
        step = next - x;
        x = next;
    }
    return x;
}

// Where in [low, high] a sample lies, u in [0,1): the filter there, normalised.
float filterOffset(uint kind, float radius, float deviation, float low, float high, float u) {
    if (kind == kFilterTent) return tentOffset(radius, low, high, u);
    return gaussianOffset(radius, deviation, low, high, u);
}

#endif

// Reconstruction filters as distributions of a pixel's samples: where a sample lies is drawn in proportion to the filter, so each belongs to one pixel and
// weighs 1 (filter importance sampling; Ernst, Stamminger and Greiner 2006). Filters are separable; along an axis, from the middle of the pixel:
//   tent      1 - |x| / radius
//   gaussian  exp(-x^2 / (2 deviation^2)) - exp(-radius^2 / (2 deviation^2))
#ifndef CMPG_LIB_PIXEL_FILTER
#define CMPG_LIB_PIXEL_FILTER
#include "shared/batch.h"

// Abramowitz and Stegun 1964, 7.1.26: within 1.5e-7.
float errorFunction(float x) {
    float a = abs(x);
    float t = 1.0 / (1.0 + 0.3275911 * a);
    float polynomial = ((((1.061405429 * t - 1.453152027) * t + 1.421413741) * t - 0.284496736) * t + 0.254829592) * t;
    float e = 1.0 - polynomial * exp(-a * a);
    return x < 0.0 ? -e : e;
}

// Of the filter, from 0 to x, |x| <= radius.
float filterIntegral(uint kind, float radius, float deviation, float x) {
    if (kind == kFilterTent) return x - x * abs(x) / (2.0 * radius);
    float edge = exp(-radius * radius / (2.0 * deviation * deviation));
    return deviation * 1.2533141373 * errorFunction(x / (deviation * 1.4142135624)) - edge * x; // sqrt(pi / 2), sqrt(2)
}

// Where in [low, high] a sample lies, u in [0,1): the filter there, normalised.
float filterOffset(uint kind, float radius, float deviation, float low, float high, float u) {
    float first = filterIntegral(kind, radius, deviation, low);
    float target = first + u * (filterIntegral(kind, radius, deviation, high) - first);
    for (uint i = 0u; i < 22u; ++i) { // to the last bits of a place in a pixel
        float middle = 0.5 * (low + high);
        bool beyond = filterIntegral(kind, radius, deviation, middle) > target;
        low = beyond ? low : middle;
        high = beyond ? middle : high;
    }
    return 0.5 * (low + high);
}

#endif

// Which texels a look-up reads and with what weight. Texture coordinate (0,0) is the top-left corner of the top-left texel.
#ifndef CMPG_LIB_TEXEL
#define CMPG_LIB_TEXEL
#include "lib/dual.glsl"

const uint kWrapRepeat = 0u; // the order of cmpg::Wrap
const uint kWrapClamp = 1u;
const uint kWrapMirror = 2u;

struct TexelWeights {
    uvec4 index; // row-major, each below width * height: (left, right) of the upper row, then of the lower row
    vec4 weight; // adds up to 1; nearest: 1, 0, 0, 0 with four equal indices
};

// Position along one axis: two neighbouring texels and the weight of the second.
struct TexelPair {
    uint first;
    uint second;
    float weight;
};

uint lastTexel(float position, uint size) { return min(uint(max(position, 0.0)), size - 1u); }

TexelPair wrapAxis(float coordinate, uint size, uint wrap, bool nearest) {
    float t = abs(coordinate) < 1e7 ? coordinate : 0.0; // beyond that float has no fraction left; not a number lands here too
    // Reduced without rounding: t - floor(t) would lose the small negative ones.
    if (wrap == kWrapClamp) t = clamp(t, 0.0, 1.0);
    else if (wrap == kWrapMirror) t = abs(t - 2.0 * roundEven(0.5 * t));
    else t = t - roundEven(t);
    // Between centres. Left of the first centre and right of the last one, repeat joins the opposite edges; mirror and clamp
    // meet the edge texel again.
    float x = t * float(size) - (nearest ? 0.0 : 0.5);
    float below = floor(x);
    TexelPair p;
    p.weight = nearest ? 0.0 : x - below;
    if (wrap == kWrapRepeat && below < 0.0) below = below + float(size);
    p.first = lastTexel(below, size);
    p.second = lastTexel(below + 1.0, size);
    if (nearest) p.second = p.first;
    else if (wrap == kWrapRepeat && !(below + 1.0 < float(size))) p.second = 0u;
    return p;
}

TexelWeights combineAxes(TexelPair u, TexelPair v, uint width) {
    TexelWeights t;
    t.index = uvec4(v.first * width + u.first, v.first * width + u.second, v.second * width + u.first, v.second * width + u.second);
    t.weight = vec4((1.0 - u.weight) * (1.0 - v.weight), u.weight * (1.0 - v.weight), (1.0 - u.weight) * v.weight, u.weight * v.weight);
    return t;
}

TexelWeights texelWeights(vec2 uv, uint width, uint height, uint wrapU, uint wrapV, bool nearest) {
    return combineAxes(wrapAxis(uv.x, width, wrapU, nearest), wrapAxis(uv.y, height, wrapV, nearest), width);
}

// Latitude-longitude maps: u wraps, the first and last row sit at the poles.
TexelWeights environmentTexelWeights(vec2 uv, uint width, uint height) {
    float y = clamp(uv.y, 0.0, 1.0) * float(height - 1u);
    float above = min(floor(y), float(max(height, 2u) - 2u));
    TexelPair v;
    v.first = lastTexel(above, height);
    v.second = min(v.first + 1u, height - 1u);
    v.weight = y - above;
    return combineAxes(wrapAxis(uv.x, width, kWrapRepeat, false), v, width);
}

#endif

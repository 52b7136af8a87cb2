// Random numbers that are a function of what they are for, never of when or where they are drawn.
#ifndef CMPG_LIB_RANDOM
#define CMPG_LIB_RANDOM
#include "lib/dual.glsl"

// What a set of random numbers belongs to.
struct SampleKey {
    uvec2 stream;     // of seed, step and pass: streamKey()
    uint pixel;
    uint sampleIndex; // within the pixel and pass; goes on over the batches of a pass
    uint branch;      // which copy of a split path
    uint bounce;
};

// pcg4d of Jarzynski and Olano 2020, "Hash Functions for GPU Rendering".
uvec4 hash4(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v = v ^ (v >> 16u);
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// The same for a whole dispatch.
uvec2 streamKey(uint seedLow, uint seedHigh, uint step, uint pass) {
    uvec4 h = hash4(uvec4(seedLow, seedHigh, step, pass));
    return uvec2(h.x, h.y);
}

// Branch of a copy but the first of an arrival that was split; the first goes on with the arrival's own.
uint copyBranch(uint branch, uint bounce, uint copy) { return hash4(uvec4(branch, bounce, copy, 0x636f7079u)).x; }

// Samples of a pixel come in blocks of 2^16, stratified within and independent of each other.
const uint kSampleBlockBits = 16u;
const uint kSampleBlockMask = 0xffffu;

// Key of one set of dimensions of a path vertex, the same for all samples of a block.
uvec4 setKey(SampleKey key, uint set) {
    uvec4 path = hash4(uvec4(key.stream.x, key.stream.y, key.pixel, key.branch));
    return hash4(uvec4(path.x + key.bounce, path.y + set, path.z + (key.sampleIndex >> kSampleBlockBits), path.w));
}

// Uniform in [0,1), in steps of 2^-24 so that float never rounds up to 1.
vec4 unitInterval(uvec4 bits) { return vec4(bits >> 8u) * (1.0 / 16777216.0); }

vec4 independentSet(SampleKey key, uint set) {
    uvec4 k = setKey(key, set);
    return unitInterval(hash4(uvec4(k.x + (key.sampleIndex & kSampleBlockMask), k.y, k.z, k.w)));
}

#endif

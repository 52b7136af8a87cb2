// Four-dimensional Sobol points with nested uniform (Owen) scrambling and shuffled order, both by hashing.
//
// Sets with different keys are independent of each other ("padding"); within one set the points 0 .. 2^m - 1 are stratified in all
// four dimensions together, best in .x with .y, which are a (0,2)-sequence. Burley 2020, "Practical Hash-based Owen Scrambling".
#ifndef CMPG_LIB_SOBOL
#define CMPG_LIB_SOBOL
#include "lib/random.glsl"

const uint kSobolBits = kSampleBlockBits; // points repeat after that many; sampler.glsl then changes the key

// The first four dimensions of Joe and Kuo 2008, with the first binary digit of each coordinate in bit 0: the order the scramble
// works in. Direction numbers follow from the recurrences of the polynomials x^2 + x + 1 and x^3 + x + 1, which the compiler
// evaluates when it unrolls the loop; x + 1 makes Pascal's triangle, which factors into shifts by powers of two.
uvec4 sobolDigits(uint index) {
    uint pascal = index ^ (index >> 16u);
    pascal = pascal ^ ((pascal >> 8u) & 0x00ff00ffu);
    pascal = pascal ^ ((pascal >> 4u) & 0x0f0f0f0fu);
    pascal = pascal ^ ((pascal >> 2u) & 0x33333333u);
    pascal = pascal ^ ((pascal >> 1u) & 0x55555555u);
    uint c = 0u, c0 = 1u, c1 = 3u;         // m = 1, 3
    uint d = 0u, d0 = 1u, d1 = 3u, d2 = 4u; // m = 1, 3, 1
    for (uint k = 0u; k < kSobolBits; ++k) {
        uint bit = 0u - ((index >> k) & 1u); // all ones where the bit is set
        c = c ^ (c0 & bit);
        d = d ^ (d0 & bit);
        uint c2 = c1 ^ c0 ^ (c0 << 2u);
        uint d3 = d1 ^ d0 ^ (d0 << 3u);
        c0 = c1;
        c1 = c2;
        d0 = d1;
        d1 = d2;
        d2 = d3;
    }
    return uvec4(index, pascal, c, d);
}

// Permutation in which every bit depends on the bits below it only (Laine and Karras 2011), with the constants Vegdahl found
// by search (2021, "Building a Better LK Hash").
uvec4 laineKarras(uvec4 x, uvec4 seed) {
    x = x ^ (x * 0x3d20adeau);
    x = x + seed;
    x = x * ((seed >> 16u) | 1u);
    x = x ^ (x * 0x05526c56u);
    x = x ^ (x * 0x53a22864u);
    return x;
}

// Point `index` of the set with this key; uniform in [0,1)^4.
vec4 sobolSet(uint index, uvec4 key) {
    // Shuffling the order permutes aligned blocks of 2^m points among themselves, so prefixes stay nets.
    uint seed = (key.x ^ key.z) + (key.y ^ key.w);
    uint backwards = bitfieldReverse(index) >> (32u - kSobolBits);
    uint shuffled = bitfieldReverse(laineKarras(uvec4(backwards), uvec4(seed)).x) >> (32u - kSobolBits);
    return unitInterval(bitfieldReverse(laineKarras(sobolDigits(shuffled), key)));
}

#endif

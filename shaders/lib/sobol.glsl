// Four-dimensional Sobol points with nested uniform (Owen) scrambling and shuffled order, both by hashing.
//
// Sets with different keys are independent of each other ("padding"); within one set the points 0 .. 2^m - 1 are stratified in all
// four dimensions together, best in .x with .y, which are a (0,2)-sequence. Burley 2020, "Practical Hash-based Owen Scrambling".
#ifndef CMPG_LIB_SOBOL
#define CMPG_LIB_SOBOL
#include "lib/random.glsl"

const uint kSobolBits = 24u; // points repeat after 2^24

// The first four dimensions of Joe and Kuo 2008 as binary fractions. Direction numbers follow from the recurrences of the
// polynomials x + 1, x^2 + x + 1 and x^3 + x + 1, which the compiler evaluates when it unrolls the loop: no tables.
uvec4 sobolPoint(uint index) {
    uvec4 point = uvec4(0u);
    uint a = 0x80000000u;                                            // van der Corput
    uint b = 0x80000000u;
    uint c0 = 0x80000000u, c1 = 0xc0000000u;                         // m = 1, 3
    uint d0 = 0x80000000u, d1 = 0xc0000000u, d2 = 0x20000000u;       // m = 1, 3, 1
    for (uint k = 0u; k < kSobolBits; ++k) {
        uint bit = 0u - ((index >> k) & 1u); // all ones where the bit is set
        point = point ^ (uvec4(a, b, c0, d0) & bit);
        a = a >> 1u;
        b = b ^ (b >> 1u);
        uint c2 = c1 ^ c0 ^ (c0 >> 2u);
        uint d3 = d1 ^ d0 ^ (d0 >> 3u);
        c0 = c1;
        c1 = c2;
        d0 = d1;
        d1 = d2;
        d2 = d3;
    }
    return point;
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

uvec4 owenScramble(uvec4 fraction, uvec4 seed) { return bitfieldReverse(laineKarras(bitfieldReverse(fraction), seed)); }

// Point `index` of the set with this key; uniform in [0,1)^4.
vec4 sobolSet(uint index, uvec4 key) {
    // Shuffling the order permutes aligned blocks of 2^m points among themselves, so prefixes stay nets.
    uint seed = (key.x ^ key.z) + (key.y ^ key.w);
    uint shuffled = owenScramble(uvec4(index << (32u - kSobolBits)), uvec4(seed)).x >> (32u - kSobolBits);
    return unitInterval(owenScramble(sobolPoint(shuffled), key));
}

#endif

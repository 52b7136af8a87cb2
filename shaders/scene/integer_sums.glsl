// Sums of 64-bit integers, whose order does not matter, so that results do not depend on scheduling. Where the device has no 64-bit
// atomics, two 32-bit words with carry.
#ifdef CMPG_PORTABLE
#define INTEGER_SUM uvec2
#define ADD_INTEGER(sum, words, highBefore) \
    { \
        const uint old_ = atomicAdd(sum.x, words.x); \
        const uint carry_ = old_ + words.x < old_ ? 1u : 0u; \
        highBefore = words.y + carry_ != 0 ? atomicAdd(sum.y, words.y + carry_) : 0u; \
    }
#else
#define INTEGER_SUM uint64_t
#define ADD_INTEGER(sum, words, highBefore) { highBefore = unpackUint2x32(atomicAdd(sum, packUint2x32(words))).y; }
#endif

// Sums stay below 2^62, so that no contribution (at most 2^62) can make them wrap around; the one after that would is counted.
bool isLargeSum(uint highWord) { return highWord + 0x40000000u > 0x7fffffffu; }

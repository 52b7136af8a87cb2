// Gradient sums as 64-bit integers in units of 2^-k: the order of additions does not matter, so results do not depend on
// scheduling. A dispatch serves the entries of one slice, since a binding's range is limited.
#ifdef CMPG_PORTABLE
layout(binding = kBindGradients, scalar) buffer Gradients { uvec2 gradients[]; };
#else
layout(binding = kBindGradients, scalar) buffer Gradients { uint64_t gradients[]; };
#endif

// Sums stay below 2^62, so that no contribution (at most 2^62) can make them wrap around; the one after that would is counted.
bool isLargeSum(uint highWord) { return highWord + 0x40000000u > 0x7fffffffu; }

// `scale`: two factors of 2^k.
void addGradient(uint entry, float value, vec2 scale) {
    const uint local = entry - push.firstEntry;
    if (value == 0.0 || local >= push.entries) return;
    uvec2 words;
    bool tooLarge = !toFixedPoint(value * scale.x, scale.y, words);
#ifdef CMPG_PORTABLE
    const uint old = atomicAdd(gradients[local].x, words.x);
    const uint carry = old + words.x < old ? 1u : 0u;
    if (words.y + carry != 0) tooLarge = isLargeSum(atomicAdd(gradients[local].y, words.y + carry)) || tooLarge;
#else
    tooLarge = isLargeSum(unpackUint2x32(atomicAdd(gradients[local], packUint2x32(words))).y) || tooLarge;
#endif
    if (tooLarge) atomicAdd(statistics[kSaturatedGradient], 1);
}

// Gradient sums in units of 2^-k. A dispatch serves the entries of one slice, since a binding's range is limited.
// Expects scene/integer_sums.glsl.
layout(binding = kBindGradients, scalar) buffer Gradients { INTEGER_SUM gradients[]; };

// `scale`: two factors of 2^k.
void addGradient(uint entry, float value, vec2 scale) {
    const uint local = entry - push.firstEntry;
    if (value == 0.0 || local >= push.entries) return;
    uvec2 words;
    bool tooLarge = !toFixedPoint(value * scale.x, scale.y, words);
    if (!tooLarge && words == uvec2(0)) {
        atomicOr(statistics[kLostGradient], 1);
        return;
    }
    uint before;
    ADD_INTEGER(gradients[local], words, before)
    tooLarge = isLargeSum(before) || tooLarge;
    if (tooLarge) atomicAdd(statistics[kSaturatedGradient], 1);
}

// The mixture weights of the guide: what light (P) and its derivatives of either sign (D+, D-) have of the distribution that directions are
// drawn from (Fan et al. 2024). The host compiles it, too: src/guiding/guide_mixture.cpp.
#ifndef CMPG_LIB_GUIDE_MIXTURE
#define CMPG_LIB_GUIDE_MIXTURE
#include "shared/guide.h"

// Below this a cell's score counts as nothing known: a cell's means are published with a typical size of 1.
const float kMinGuideScore = 1e-20;
const float kPositivizedShare = 0.95; // of the wanted sign; the rest defends against a wrongly learned one

// What each of P, D+, D- counts in the mixture. `total`: their means in the cell; lightWeight = mean_rgb of the bound on the
// derivative of the throughput, derivativeWeight = mean_rgb of the throughput; sign: as in Batch (shared/batch.h).
vec3 guideWeights(uint kind, vec3 total, float lightWeight, float derivativeWeight, int sign) {
    float derivative = total.y + total.z;
    // Weights of D+ and D- whose sum over the masses is that of (1, 1). A part next to nothing counts as none: its weight would overflow.
    vec2 split = vec2(1.0, 1.0);
    if (sign != 0 && min(total.y, total.z) > 1e-12 * derivative) {
        float plus = sign > 0 ? kPositivizedShare : 1.0 - kPositivizedShare;
        split = vec2(derivative * plus / total.y, derivative * (1.0 - plus) / total.z);
    }
    float larger = max(lightWeight, derivativeWeight); // products with the masses cannot overflow
    float light = larger > 0.0 ? lightWeight / larger : 0.0, differential = larger > 0.0 ? derivativeWeight / larger : 0.0;
    vec3 primal = vec3(1.0, 0.0, 0.0);
    vec3 derivatives = vec3(0.0, split.x, split.y);
    vec3 inverse = vec3(total.x > 0.0 ? 1.0 / total.x : 0.0, derivative > 0.0 ? (1.0 / derivative) * split : vec2(0.0));
    vec3 conditional = vec3(light, split.x * differential, split.y * differential);
    // Selected, not branched to: lavapipe compiles a kernel for the kind that it finds in the uniform buffer, where a branch by it changes the kernel much, and then
    // anew in every dispatch.
    vec3 weights = kind == kGuidePrimal ? primal : vec3(0.0);
    weights = kind == kGuideDifferential ? derivatives : weights;
    weights = kind == kGuideUniform ? inverse : weights;
    return kind == kGuideConditional ? conditional : weights;
}

// The conditional mixture with a quarter of P at least, where P knows something. What derivatives brought back is learned from few
// records, most of them zero; where it alone decides, as at a camera's vertex, light finds the directions it missed.
vec3 guideDefended(vec3 weights, vec3 total) {
    float derivative = weights.y * total.y + weights.z * total.z;
    float least = total.x > 0.0 ? derivative / (float(kDefensiveParts - 1u) * total.x) : 0.0;
    return vec3(max(weights.x, least), weights.y, weights.z);
}

// What P, D+, D- have of the mixture, with the sum 1; all 0 where nothing is known.
vec3 guideParts(vec3 weights, vec3 total) {
    vec3 scores = weights * total;
    float score = scores.x + scores.y + scores.z;
    return score > kMinGuideScore ? scores / score : vec3(0.0);
}

// Which of the parts of a mixture, with the sum 1, a draw is from; u in [0,1).
uint guidePart(vec3 parts, float u) {
    if (u < parts.x || parts.y + parts.z <= 0.0) return 0u;
    return u - parts.x < parts.y || parts.z <= 0.0 ? 1u : 2u;
}

#endif

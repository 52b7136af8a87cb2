// What the backward scan does with a vertex's derivative record: forward mode contracts it with the direction, reverse mode adds it to
// the gradient sums. Expects tapeWord(), directionAt(), addGradient() and push.
#include "scene/asked_slots.glsl"

float tapeGet(uint slot, uint plane) { return uintBitsToFloat(tapeWord(plane * push.count + slot)); }
vec2 tapeGet2(uint slot, uint plane) { return vec2(tapeGet(slot, plane), tapeGet(slot, plane + 1)); }
vec3 tapeGet3(uint slot, uint plane) { return vec3(tapeGet(slot, plane), tapeGet(slot, plane + 1), tapeGet(slot, plane + 2)); }

// What a vertex adds to the gradient: the sum over its slots of adjoint times throughput times term, and the entry it mostly went to.
struct Contribution {
    vec3 sum;
    uint entry;
};

void addContribution(INOUT(Contribution) own, SlotAddress a, uint stride, vec3 g) {
    if (!kMeasure) return;
    own.sum += g;
    const vec4 w = a.texels.weight;
    const bool right = w.y + w.w > w.x + w.z, low = w.z + w.w > w.x + w.y;
    own.entry = a.gradient + stride * (low ? (right ? a.texels.index.w : a.texels.index.z) : (right ? a.texels.index.y : a.texels.index.x));
}

// The derivative terms of a vertex by where their light came from, and what they add to the gradient.
struct Terms {
    DerivativeParts drawn; // with the drawn direction: |dw X| here, w (|dE| + T) from further along
    DerivativeParts lit; // with the light sample: |dN|
    DerivativeParts emitted; // |dE|: emission found here
    Contribution own;
};

DerivativeParts noParts() { return DerivativeParts(vec3(0), vec3(0)); }
Terms noTerms() { return Terms(noParts(), noParts(), noParts(), Contribution(vec3(0), kNone)); }

void addParts(INOUT(DerivativeParts) parts, vec3 value) {
    if (!kRecord) return;
    parts.plus += max(value, vec3(0));
    parts.minus += max(-value, vec3(0));
}

// Positivization keeps the terms of one sign.
vec3 wantedSign(vec3 value) {
    if (!kSigned) return value;
    return batch.sign > 0 ? max(value, vec3(0)) : min(value, vec3(0));
}

vec3 finiteDerivative(vec3 g) {
    if (!any(isnan(g)) && !any(isinf(g))) return g;
    atomicAdd(statistics[kDroppedDerivative], 1);
    return vec3(0);
}

// `value`: derivative of each channel with respect to the same channel of a colour read through `a`.
vec3 colorTerm(SlotAddress a, vec3 value, vec3 reach, vec2 scale, INOUT(Contribution) own) {
    if (kReverse) {
        const vec3 g = reach * value;
        addContribution(own, a, 3, g);
        for (uint k = 0; k < 4; ++k)
            if (a.texels.weight[k] != 0.0)
                for (uint c = 0; c < 3; ++c) addGradient(a.gradient + 3 * a.texels.index[k] + c, a.texels.weight[k] * g[c], scale);
        return vec3(0);
    }
    vec3 along = vec3(0);
    for (uint k = 0; k < 4; ++k)
        if (a.texels.weight[k] != 0.0)
            for (uint c = 0; c < 3; ++c) along[c] += a.texels.weight[k] * directionAt(a.gradient + 3 * a.texels.index[k] + c);
    return value * along;
}

// `value`: derivative of the three channels with respect to one number read through `a`.
vec3 scalarTerm(SlotAddress a, vec3 value, uint stride, uint component, vec3 reach, vec2 scale, INOUT(Contribution) own) {
    float along = 0.0;
    const float g = dot(reach, value);
    addContribution(own, a, stride, vec3(g, 0, 0));
    for (uint k = 0; k < 4; ++k) {
        if (a.texels.weight[k] == 0.0) continue;
        const uint entry = a.gradient + stride * a.texels.index[k] + component;
        if (kReverse) addGradient(entry, a.texels.weight[k] * g, scale);
        else along += a.texels.weight[k] * directionAt(entry);
    }
    return value * along;
}

// dN_i V + dw_i X of one place.
vec3 placeDerivative(uint slot, uint place, vec3 incident, float visible, INOUT(Terms) terms) {
    const uint at = kTapeDerivative * place;
    const vec3 drawn = finiteDerivative(tapeGet3(slot, kPlaneDrawn + at) * incident), lit = finiteDerivative(visible * tapeGet3(slot, kPlaneLit + at));
    addParts(terms.drawn, drawn);
    addParts(terms.lit, lit);
    const vec3 value = wantedSign(drawn) + wantedSign(lit);
    return value;
}

// Sum over the slots of the surface: T_i without what comes from further along the path.
vec3 surfaceTerms(uint slot, uint material, vec2 uv0, vec2 uv1, vec3 incident, float visible, vec3 reach, INOUT(Terms) terms) {
    vec3 sum = vec3(0);
    const uint flags = materialTexel(material * kMaterialTexels + 1).w, asked = askedSlots(material, flags);
#define SURFACE_SLOT(number, Name, name, channels, highest, adam, sgd) \
    if (kDiff##Name && (asked & (1u << number)) != 0) { \
        const SlotAddress a = slotAddress(material, number, uv0, uv1); \
        const vec3 value = placeDerivative(slot, kAt##Name, incident, visible, terms); \
        if (channels == 3 || (number == kSlotSpecular && kSpecularColor && (a.flags & kSlotScalar) == 0)) \
            sum += colorTerm(a, value, reach, batch.surfaceScale, terms.own); \
        else \
            sum += scalarTerm(a, value, 1, 0, reach, batch.surfaceScale, terms.own); \
    }
#define LOBE_COLOR_SLOT(number, Name, name, channels, highest, adam, sgd, extension, factor, standard, texture, channel) \
    if (kDiff##Name && (asked & (1u << number)) != 0) { \
        const SlotAddress a = slotAddress(material, number, uv0, uv1); \
        for (uint c = 0; c < 3; ++c) \
            sum += scalarTerm(a, placeDerivative(slot, kAt##Name + c, incident, visible, terms), 3, c, reach, batch.surfaceScale, terms.own); \
    }
#include "shared/slots.def"
    if (kDiffNormal && (asked & (1u << kSlotNormal)) != 0) {
        const SlotAddress a = slotAddress(material, kSlotNormal, uv0, uv1);
        for (uint c = 0; c < 3; ++c)
            sum += scalarTerm(a, placeDerivative(slot, kAtNormal + c, incident, visible, terms), 3, c, reach, batch.normalScale, terms.own);
    }
    if (kDiffWeight && (flags & kMaterialWeightDifferentiated) != 0)
        sum += scalarTerm(slotAddress(material, kSlotWeight, uv0, uv1), placeDerivative(slot, kAtWeight, incident, visible, terms), 1, 0, reach, batch.surfaceScale, terms.own);
    return sum;
}

// Emission that reaches the vertex with `factor`: of a material, or of the environment at map coordinates uv0.
vec3 emissionTerm(uint material, vec2 uv0, vec2 uv1, vec3 factor, vec3 reach, INOUT(DerivativeParts) parts, INOUT(Contribution) own) {
    SlotAddress a;
    if (material == kNone) {
        if (!kDiffRadiance) return vec3(0);
        a.offset = 0;
        a.flags = 0;
        a.gradient = scene.environment.gradient;
        a.texels = environmentTexelWeights(uv0, scene.environment.width, scene.environment.height);
    } else {
        if (!kDiffEmission) return vec3(0);
        a = slotAddress(material, kSlotEmission, uv0, uv1);
    }
    if (a.gradient == kNone) return vec3(0);
    const vec3 term = finiteDerivative(factor);
    addParts(parts, term);
    return colorTerm(a, wantedSign(term), reach, batch.emissionScale, own);
}

// The clear coat of KHR_materials_clearcoat: a layer of GGX over metallic-roughness and its sheen, which get what the layer does not reflect.
//
//   f = (1 - w) base + w GGX,   w = clearcoat (0.04 + 0.96 (1 - |n.wo|)^5)
//
// w goes by the direction to the camera alone, as the extension has it, so f is not reciprocal. n is the coat's own normal where it has one, else that of
// the base. Either reflects between directions on one side of its own normal.
#ifndef CMPG_LIB_CLEAR_COAT
#define CMPG_LIB_CLEAR_COAT
#include "lib/lobes/sheen.glsl"

// The includer defines kTexturedClearcoat: some material has the lobe.
#define HAS_CLEAR_COAT(s) (kTexturedClearcoat && ((s).model >> kSlotClearcoat & 1u) != 0u)
// The includer defines kCoatNormals. No function, as HAS_CLEAR_COAT is none.
#define HAS_COAT_NORMAL(s) (kCoatNormals && dot((s).coatNormal, (s).coatNormal) > 0.0)
#define CLEAR_COAT(s) ((s).lobe[kSlotClearcoat - kCommonSlots])
#define CLEAR_COAT_ROUGHNESS(s) ((s).lobe[kSlotClearcoatRoughness - kCommonSlots])

// Schlick's approximation at cosO = |n.wo|, for an index of refraction of 1.5; and its derivative by cosO.
vec2 clearCoatFresnel(float cosO) {
    float x = max(1.0 - cosO, 0.0);
    float x4 = square(square(x));
    return vec2(0.04 + 0.96 * x4 * x, -4.8 * x4);
}

float clearCoatAlpha(Surface s) { return alphaFromRoughness(CLEAR_COAT_ROUGHNESS(s)); }

// Probability of drawing from the coat; as those of the lobes below, in [0.1, 0.9] where there is something to draw from on both. coatO: by the coat's normal.
float clearCoatProbability(Surface s, float cosO, float coatO) {
    if (HAS_COAT_NORMAL(s) && !(coatO > kMinCosine)) return 0.0;
    float weight = CLEAR_COAT(s) * clearCoatFresnel(coatO).x;
    if (!(weight > 0.0 || (kDiffClearcoat && asks(s, kSlotClearcoat)))) return 0.0;
    if (!(metallicRoughnessDiffuse(s) || metallicRoughnessSpecular(s) || (HAS_SHEEN(s) && sheenProbability(s, cosO) > 0.0))) return 1.0;
    float base = (1.0 - weight) * max(maxComponent(s.baseColor), 0.04);
    return clamp(weight / max(weight + base, 1e-6), 0.1, 0.9);
}

// f |cos| with the coat over a base whose f |cos| is `base`, and whose derivatives are in d. By a normal of its own there is no derivative, and by the base's
// none of the coat then.
vec3 clearCoatedCos(Surface s, vec3 n, vec3 wo, vec3 wi, float cosO, float cosI, vec3 base, INOUT(BsdfDerivatives) d) {
    vec3 coatN = n;
    float coatO = cosO;
    float coatI = cosI;
    if (HAS_COAT_NORMAL(s)) {
        coatN = facing(s.coatNormal, wo);
        coatO = accurateDot(coatN, wo);
        coatI = accurateDot(coatN, wi);
    }
    vec2 fresnelTerm = clearCoatFresnel(coatO);
    float weight = CLEAR_COAT(s) * fresnelTerm.x;
    MicrofacetReflection g = ggxReflection(clearCoatAlpha(s), coatN, wo, wi, coatO, coatI, halfVector(coatN, wo, wi));
    if (HAS_COAT_NORMAL(s) && !(min(coatO, coatI) > kMinCosine)) {
        g.value = 0.0;
        g.alpha = 0.0;
    }
    vec3 difference = vec3(g.value) - base;
    for (uint k = 0u; k < kDerivativePlaces; ++k) d.at[k] = d.at[k] * (1.0 - weight);
    if (kDiffClearcoat) d.at[kAtClearcoat] = fresnelTerm.x * difference;
    if (kDiffClearcoatRoughness) d.at[kAtClearcoatRoughness] = vec3(weight * (g.alpha * alphaDerivative(CLEAR_COAT_ROUGHNESS(s))));
    if (kDiffNormal && !HAS_COAT_NORMAL(s)) {
        addNormalDerivative(d, difference, (wo - cosO * n) * (CLEAR_COAT(s) * fresnelTerm.y));
        addNormalDerivative(d, vec3(weight), g.normal);
    }
    return (1.0 - weight) * base + vec3(weight * g.value);
}

// A direction that the coat reflects. False: it ends below the surface.
bool sampleClearCoat(Surface s, vec3 n, vec3 wo, vec3 u, OUT(vec3) wi) {
    vec3 x;
    vec3 y;
    orthonormalFrame(n, x, y);
    vec3 o = vec3(dot(x, wo), dot(y, wo), accurateDot(n, wo));
    vec3 h = sampleGgxNormal(clearCoatAlpha(s), o, vec2(u.x, u.y));
    vec3 local = 2.0 * dot(o, h) * h - o;
    wi = normalize(local.x * x + local.y * y + local.z * n);
    return dot(n, wi) > kMinCosine;
}

#endif

// The sheen of KHR_materials_sheen: a layer of fibres over metallic-roughness, which gets what the layer leaves (Estevez and Kulla 2017, "Production Friendly
// Microfacet Sheen BRDF").
//
//   f = sheenColor D V + (1 - max(sheenColor) max(E(n.wo), E(n.wi))) base,   alpha = max(sheenRoughness, 0.07)^2,
//   D = (2 + 1 / alpha) sin(h)^(1 / alpha) / (2 pi),   V = 1 / (4 (n.wo) (n.wi) (1 + L(n.wo) + L(n.wi))),
//   L = exp(l(c)) for c < 1/2, else exp(2 l(1/2) - l(1 - c)),   l(x) = a / (1 + b x^c) + d x + e,
//
// a to e being mixes of two constants each by (1 - alpha)^2. E(c) is what D V reflects of a uniform sky (sheenAlbedo). Of small roughness it is above 1 at grazing
// angles; the base then gets nothing, not less. Sheen and base share their normal.
#ifndef CMPG_LIB_SHEEN
#define CMPG_LIB_SHEEN
#include "lib/lobes/metallic_roughness.glsl"

// The includer defines kTexturedSheenColor: some material has the lobe.
#define HAS_SHEEN(s) (kTexturedSheenColor && IS_METALLIC_ROUGHNESS(s) && ((s).model & kMaterialSheen) != 0u)
#define SHEEN_ROUGHNESS(s) ((s).lobe[kSlotSheenRoughness - kCommonSlots])

const float kMinSheenRoughness = 0.07; // below it D is a rim thinner than pixels, brighter than 30
const float kMinSheenCosine = 0.002;   // E is the same below it

float sheenRoughness(Surface s) { return max(SHEEN_ROUGHNESS(s), kMinSheenRoughness); }

struct SheenAlbedo {
    float value;
    float cosine;    // its derivatives
    float roughness;
};

// Of a polynomial of the fifth degree: value and derivative.
vec2 sheenQuintic(float r, vec3 low, vec3 high) {
    float value = low.x + r * (low.y + r * (low.z + r * (high.x + r * (high.y + r * high.z))));
    float slope = low.y + r * (2.0 * low.z + r * (3.0 * high.x + r * (4.0 * high.y + r * (5.0 * high.z))));
    return vec2(value, slope);
}

// A step of Horner's rule in x: value, derivatives by x and by what the coefficient depends on.
vec3 sheenHorner(vec3 p, float x, vec2 coefficient) { return vec3(p.x * x + coefficient.x, p.y * x + p.x, p.z * x + coefficient.y); }

// E: exp of a polynomial in x = (c / r)^0.4 and r, over r, fitted to numerical integrals and their slopes by r from 0.06 to 1.06. It is within 0.004 of them for r from 0.07
// to 1 and c from 0.002, its slope by r within 0.06, or 6 % where that is steeper than 1.
SheenAlbedo sheenAlbedo(float cosine, float r) {
    float c = max(cosine, kMinSheenCosine);
    float x = pow(c / r, 0.4);
    vec3 p = vec3(0.0);
    p = sheenHorner(p, x, sheenQuintic(r, vec3(0.5899973, -16.57853, 0.0), vec3(0.0)));
    p = sheenHorner(p, x, sheenQuintic(r, vec3(-1.723504, 71.42698, -13.10593), vec3(0.0)));
    p = sheenHorner(p, x, sheenQuintic(r, vec3(0.4312275, -120.5581, 37.02664), vec3(0.0)));
    p = sheenHorner(p, x, sheenQuintic(r, vec3(2.820132, 102.7681, -45.87996), vec3(3.817944, 0.0, 0.0)));
    p = sheenHorner(p, x, sheenQuintic(r, vec3(-5.292371, -45.1805, 30.7133), vec3(-9.545365, 1.927037, 0.0)));
    p = sheenHorner(p, x, sheenQuintic(r, vec3(2.098156, 6.966617, -3.34984), vec3(-2.986478, 2.401042, -0.2620365)));
    p = sheenHorner(p, x, sheenQuintic(r, vec3(-1.898581, 1.039645, -1.863226), vec3(8.550347, -8.68429, 2.502554)));
    SheenAlbedo e;
    e.value = exp(p.x) / r;
    float stretch = p.y * (0.4 * x);
    e.cosine = cosine > kMinSheenCosine ? e.value * stretch / c : 0.0;
    e.roughness = e.value * (p.z - (stretch + 1.0) / r);
    return e;
}

// l(x) and its derivatives by x and alpha; x > 0.
vec3 sheenMaskingExponent(float x, float alpha) {
    float smoothness = square(1.0 - alpha);
    float a = 21.5473 + 3.7772 * smoothness;
    float b = 3.82987 - 0.50552 * smoothness;
    float c = 0.19823 - 0.03022 * smoothness;
    float d = -1.9776 + 0.70367 * smoothness;
    float e = -4.32054 - 0.53913 * smoothness;
    float logX = log(x);
    float power = exp(c * logX);
    float over = 1.0 / (1.0 + b * power);
    float slope = -a * over * over * power; // of a / (1 + b x^c) by b
    float bySmoothness = 3.7772 * over + slope * (-0.50552 - 0.03022 * b * logX) + 0.70367 * x - 0.53913;
    return vec3(a * over + d * x + e, slope * b * c / x + d, -2.0 * (1.0 - alpha) * bySmoothness);
}

// L and its derivatives by the cosine and alpha.
vec3 sheenMasking(float cosine, float alpha) {
    if (cosine < 0.5) {
        vec3 l = sheenMaskingExponent(cosine, alpha);
        float masking = exp(l.x);
        return vec3(masking, masking * l.y, masking * l.z);
    }
    vec3 half_ = sheenMaskingExponent(0.5, alpha);
    vec3 l = sheenMaskingExponent(max(1.0 - cosine, 1e-7), alpha);
    float masking = exp(2.0 * half_.x - l.x);
    return vec3(masking, masking * l.y, masking * (2.0 * half_.z - l.z));
}

// Probability of drawing from the sheen, a hemisphere by cosine, rather than from the base.
float sheenProbability(Surface s, float cosO) {
    float strongest = maxComponent(s.sheenColor);
    if (!(strongest > 0.0 || (kDiffSheenColor && asks(s, kSlotSheenColor)))) return 0.0;
    if (!(metallicRoughnessDiffuse(s) || metallicRoughnessSpecular(s))) return 1.0;
    float reflected = strongest * sheenAlbedo(cosO, sheenRoughness(s)).value;
    float base = max(1.0 - reflected, 0.0) * max(maxComponent(s.baseColor), 0.04);
    return clamp(reflected / max(reflected + base, 1e-6), 0.1, 0.9);
}

// f |cos| with the sheen over a base whose f |cos| is `base`, and whose derivatives are in d.
vec3 sheenOverCos(Surface s, vec3 n, vec3 wo, vec3 wi, float cosO, float cosI, vec3 base, INOUT(BsdfDerivatives) d) {
    float r = sheenRoughness(s);
    float alpha = r * r;
    float perAlpha = 1.0 / alpha;
    HalfVector h = halfVector(n, wo, wi);
    float sin2 = max(h.sin2, 1e-30);
    float logSin2 = log(sin2);
    vec3 maskingO = sheenMasking(cosO, alpha);
    vec3 maskingI = sheenMasking(cosI, alpha);
    float over = 1.0 / (1.0 + maskingO.x + maskingI.x);
    float g = (2.0 + perAlpha) * exp(0.5 * perAlpha * logSin2) * (0.125 * kInvPi) * over / cosO; // D V cosI
    float strongest = maxComponent(s.sheenColor);
    SheenAlbedo albedoO = sheenAlbedo(cosO, r);
    SheenAlbedo albedoI = sheenAlbedo(cosI, r);
    bool outgoing = albedoO.value > albedoI.value;
    float albedo = outgoing ? albedoO.value : albedoI.value;
    float kept = 1.0 - strongest * albedo;
    float live = kept > 0.0 ? 1.0 : 0.0;
    kept = max(kept, 0.0);
    for (uint k = 0u; k < kDerivativePlaces; ++k) d.at[k] = d.at[k] * kept;
    if (kDiffSheenColor) {
        // The base goes by the largest channel; where several are, each counts for its share.
        vec3 largest = vec3(s.sheenColor.x == strongest ? 1.0 : 0.0, s.sheenColor.y == strongest ? 1.0 : 0.0, s.sheenColor.z == strongest ? 1.0 : 0.0);
        vec3 taken = base * (live * albedo / (largest.x + largest.y + largest.z));
        d.at[kAtSheenColor] = vec3(g, 0.0, 0.0) - largest.x * taken;
        d.at[kAtSheenColor + 1u] = vec3(0.0, g, 0.0) - largest.y * taken;
        d.at[kAtSheenColor + 2u] = vec3(0.0, 0.0, g) - largest.z * taken;
    }
    if (kDiffSheenRoughness) {
        // ln D = ln(2 + 1 / alpha) + ln(sin2) / (2 alpha) + ...
        float byAlpha = -perAlpha * (1.0 / (2.0 * alpha + 1.0) + 0.5 * perAlpha * logSin2) - (maskingO.z + maskingI.z) * over;
        float taken = live * strongest * (outgoing ? albedoO.roughness : albedoI.roughness);
        float above = SHEEN_ROUGHNESS(s) > kMinSheenRoughness ? 1.0 : 0.0;
        d.at[kAtSheenRoughness] = (s.sheenColor * (g * byAlpha * 2.0 * r) - base * taken) * above;
    }
    if (kDiffNormal) {
        vec3 tangentialO = wo - cosO * n;
        vec3 tangentialI = wi - cosI * n;
        addNormalDerivative(d, s.sheenColor, g * (h.slope * (-perAlpha / sin2) - tangentialO * (1.0 / cosO + maskingO.y * over) - tangentialI * (maskingI.y * over)));
        vec3 byAlbedo = outgoing ? tangentialO * albedoO.cosine : tangentialI * albedoI.cosine;
        addNormalDerivative(d, base, byAlbedo * (-live * strongest));
    }
    return s.sheenColor * g + kept * base;
}

// A direction by cosine. False: it ends below the surface.
bool sampleSheen(vec3 n, vec3 u, OUT(vec3) wi) {
    vec3 x;
    vec3 y;
    orthonormalFrame(n, x, y);
    vec3 local = sampleCosineHemisphere(vec2(u.x, u.y));
    wi = normalize(local.x * x + local.y * y + local.z * n);
    return dot(n, wi) > kMinCosine;
}

#endif

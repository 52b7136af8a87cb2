// GGX reflection on isotropic rough surfaces, in forms that keep relative accuracy for roughness -> 0 and at grazing angles.
//
// Walter et al. 2007; Smith masking separable, G = G1(wo) G1(wi). With c = |n.w| and r(c) = sqrt(a^2 + (1-a^2) c^2),
// G1(c) / (2c) = 1 / (c + r), so no cosine is ever divided by.
#ifndef CMPG_LIB_MICROFACET
#define CMPG_LIB_MICROFACET
#include "lib/math.glsl"

const float kMinAlpha = 1e-3;

float alphaFromRoughness(float roughness) { return max(roughness * roughness, kMinAlpha); }
// 0 at and below the floor.
float alphaDerivative(float roughness) { return roughness * roughness > kMinAlpha ? 2.0 * roughness : 0.0; }

// The half vector seen from the normal. Both directions are on the normal's side.
struct HalfVector {
    float cos2;   // of the angle between normal and half vector, squared
    float sin2;
    vec3 slope;   // cos * (h - (n.h) n): half the gradient of cos2 over the normals of unit length
};

HalfVector halfVector(vec3 n, vec3 wo, vec3 wi) {
    vec3 m = wo + wi;
    vec3 t = accurateCross(n, m) + cross(n, sumError(wo, wi));
    float c = dot(n, m);
    float s2 = dot(t, t);
    float scale = 1.0 / (c * c + s2);
    HalfVector h;
    h.cos2 = c * c * scale;
    h.sin2 = s2 * scale;
    h.slope = cross(t, n) * (c * scale);
    return h;
}

// Schlick's approximation F = f0 keep + grazing: grazing = (1 - |w.h|)^5, keep = 1 - grazing, both with relative accuracy.
struct Schlick {
    float keep;
    float grazing;
};

Schlick schlickWeights(vec3 wo, vec3 wi) {
    vec3 m = wo + wi;
    vec3 d = wo - wi;
    float c = min(0.5 * length(m), 1.0);
    float x = min(dot(d, d) / (4.0 * (1.0 + c)), 1.0); // 1 - c without cancellation when the directions meet
    float x2 = x * x;
    Schlick f;
    f.grazing = x2 * x2 * x;
    f.keep = c * (1.0 + x + x2 + x2 * x + x2 * x2);
    return f;
}

// Distribution of normals D, per steradian of half vectors.
float ggxDistribution(float alpha, HalfVector h) {
    float q = h.sin2 + alpha * alpha * h.cos2;
    return alpha * alpha * kInvPi / (q * q);
}

float smithRoot(float alpha, float c) { return sqrt(alpha * alpha + (1.0 - alpha) * (1.0 + alpha) * c * c); }

// Solid-angle density of sampleGgx for cosO = |n.wo|: the density G1 D / (4 cosO) of reflected visible normals.
float ggxPdf(float alpha, float cosO, HalfVector h) {
    return ggxDistribution(alpha, h) / (2.0 * (cosO + smithRoot(alpha, cosO)));
}

// D G / (4 cosO cosI) * cosI without Fresnel, and its derivatives.
struct GgxReflection {
    float value;
    float alpha;  // d value / d alpha
    vec3 normal;  // gradient over unit normals, tangential: it has no part along n
};

GgxReflection ggxReflection(float alpha, vec3 n, vec3 wo, vec3 wi, float cosO, float cosI, HalfVector h) {
    float a2 = alpha * alpha;
    float b2 = (1.0 - alpha) * (1.0 + alpha);
    float q = h.sin2 + a2 * h.cos2;
    float rO = smithRoot(alpha, cosO);
    float rI = smithRoot(alpha, cosI);
    float dv = a2 * kInvPi / (q * q) / ((cosO + rO) * (cosI + rI)); // D times visibility
    GgxReflection g;
    g.value = dv * cosI;
    // ln D = 2 ln a - 2 ln q; d q / d a = 2 a cos2; d r / d a = a (1 - c^2) / r.
    g.alpha = g.value * (2.0 / alpha * (h.sin2 - a2 * h.cos2) / q
                         - alpha * (1.0 - cosO) * (1.0 + cosO) / (rO * (cosO + rO))
                         - alpha * (1.0 - cosI) * (1.0 + cosI) / (rI * (cosI + rI)));
    // d ln(c + r) / d c = (r + b2 c) / (r (c + r)); for wi the factor cosI turns 1 - cosI (...) into a2 / (r (c + r)).
    g.normal = h.slope * (4.0 * b2 * g.value / q)
             - (wo - cosO * n) * (g.value * (rO + b2 * cosO) / (rO * (cosO + rO)))
             + (wi - cosI * n) * (dv * a2 / (rI * (cosI + rI)));
    return g;
}

// A half vector by the visible normals of wo, in the frame where n = (0, 0, 1) and wo.z > 0; u in [0,1)^2.
// Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps"; the cap's sine is formed without cancellation.
vec3 sampleGgxNormal(float alpha, vec3 wo, vec2 u) {
    vec3 stretched = normalize(vec3(alpha * wo.x, alpha * wo.y, wo.z));
    float rise = 1.0 + stretched.z;
    float drop = u.y * rise; // 1 - height on the cap
    float height = (1.0 - u.y) * rise; // above its lower end, which lies 1 - stretched.z above the sphere's
    float radius = sqrt(drop * (height + (stretched.x * stretched.x + stretched.y * stretched.y) / rise));
    vec2 on = radius * unitCircle(u.x);
    vec3 h = vec3(on.x + stretched.x, on.y + stretched.y, height);
    return normalize(vec3(alpha * h.x, alpha * h.y, h.z));
}

#endif

// Reflection by microfacets of rough surfaces, here isotropic ones (lobes/anisotropy.glsl has the others), GGX or Beckmann, in forms that keep relative accuracy for roughness -> 0 and at
// grazing angles.
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
    vec3 across;  // n x h
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
    h.across = t * inversesqrt(c * c + s2);
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
struct MicrofacetReflection {
    float value;
    float alpha;  // d value / d alpha; where it is anisotropic: by the alpha of the roughness slot
    float anisotropy; // by the anisotropy slot
    vec3 normal;  // gradient over unit normals, tangential: it has no part along n
};

MicrofacetReflection ggxReflection(float alpha, vec3 n, vec3 wo, vec3 wi, float cosO, float cosI, HalfVector h) {
    float a2 = alpha * alpha;
    float b2 = (1.0 - alpha) * (1.0 + alpha);
    float q = h.sin2 + a2 * h.cos2;
    float rO = smithRoot(alpha, cosO);
    float rI = smithRoot(alpha, cosI);
    float dv = a2 * kInvPi / (q * q) / ((cosO + rO) * (cosI + rI)); // D times visibility
    MicrofacetReflection g;
    g.anisotropy = 0.0;
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

// Beckmann's distribution of normals.
float beckmannDistribution(float alpha, HalfVector h) {
    if (!(h.cos2 > 1e-8)) return 0.0; // exp(-1e8)
    float scale = 1.0 / (alpha * alpha);
    return exp(-h.sin2 / h.cos2 * scale) * scale * kInvPi / (h.cos2 * h.cos2);
}

// Masking of Beckmann's normals at cosine c > 0, in Walter's rational approximation, and its derivatives.
struct BeckmannMasking {
    float visibility; // G1 / (2 c)
    float g1;
    float alpha;  // d ln G1 / d alpha
    float cosine; // d G1 / d c
};

BeckmannMasking beckmannMasking(float alpha, float c) {
    BeckmannMasking m;
    float s2 = (1.0 - c) * (1.0 + c);
    m.g1 = 1.0;
    m.alpha = 0.0;
    m.cosine = 0.0;
    m.visibility = 0.5 / c;
    if (c * c >= 2.56 * alpha * alpha * s2) return m; // a >= 1.6
    float perC = 1.0 / (alpha * sqrt(s2));
    float a = c * perC;
    float over = 1.0 / (1.0 + a * (2.276 + 2.577 * a));
    m.visibility = 0.5 * perC * (3.535 + 2.181 * a) * over;
    m.g1 = a * (3.535 + 2.181 * a) * over;
    float slope = ((3.535 + 4.362 * a) - m.g1 * (2.276 + 5.154 * a)) * over; // d G1 / d a
    m.alpha = -slope * perC * (0.5 / m.visibility) / alpha;                  // -a slope / (G1 alpha)
    m.cosine = slope * perC / s2;
    return m;
}

MicrofacetReflection beckmannReflection(float alpha, vec3 n, vec3 wo, vec3 wi, float cosO, float cosI, HalfVector h) {
    MicrofacetReflection g;
    float d = beckmannDistribution(alpha, h);
    g.value = 0.0;
    g.alpha = 0.0;
    g.anisotropy = 0.0;
    g.normal = vec3(0.0);
    if (!(d > 0.0)) return g;
    BeckmannMasking o = beckmannMasking(alpha, cosO);
    BeckmannMasking i = beckmannMasking(alpha, cosI);
    g.value = d * o.visibility * 0.5 * i.g1;
    float steep = h.sin2 / (h.cos2 * alpha * alpha);
    g.alpha = g.value * (2.0 / alpha * (steep - 1.0) + o.alpha + i.alpha);
    // d ln D / d cos2 = 1 / (alpha^2 cos2^2) - 2 / cos2.
    g.normal = h.slope * (2.0 * g.value / h.cos2 * (1.0 / (alpha * alpha * h.cos2) - 2.0))
             + (wo - cosO * n) * (d * 0.5 * i.g1 * (o.cosine - 2.0 * o.visibility) / (2.0 * cosO))
             + (wi - cosI * n) * (d * o.visibility * 0.5 * i.cosine);
    return g;
}

// A half vector by the visible normals of wo, in the frame where n = (0, 0, 1) and wo.z > 0; alpha along its x and y; u in [0,1)^2.
// Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps"; the cap's sine is formed without cancellation.
vec3 sampleGgxNormal(vec2 alpha, vec3 wo, vec2 u) {
    vec3 stretched = normalize(vec3(alpha.x * wo.x, alpha.y * wo.y, wo.z));
    float rise = 1.0 + stretched.z;
    float drop = u.y * rise; // 1 - height on the cap
    float height = (1.0 - u.y) * rise; // above its lower end, which lies 1 - stretched.z above the sphere's
    float radius = sqrt(drop * (height + (stretched.x * stretched.x + stretched.y * stretched.y) / rise));
    vec2 on = radius * unitCircle(u.x);
    vec3 h = vec3(on.x + stretched.x, on.y + stretched.y, height);
    return normalize(vec3(alpha.x * h.x, alpha.y * h.y, h.z));
}
vec3 sampleGgxNormal(float alpha, vec3 wo, vec2 u) { return sampleGgxNormal(vec2(alpha), wo, u); }

#endif

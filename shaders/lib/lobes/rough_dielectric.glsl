// A boundary between two dielectrics with microfacets: reflection and refraction (Walter et al. 2007, "Microfacet Models for Refraction through Rough
// Surfaces"; GGX or Beckmann, Smith masking separable). Radiance is scaled as in dielectric.glsl.
#ifndef CMPG_LIB_ROUGH_DIELECTRIC
#define CMPG_LIB_ROUGH_DIELECTRIC
#include "lib/lobes/anisotropy.glsl"
#include "lib/lobes/dielectric.glsl"

// The microfacet that reflects or refracts wi to wo.
struct Facet {
    HalfVector h;
    float cosine;   // |wo.h|; 0: there is none
    float jacobian; // 4 |wo.h| dh / dwi, without eta^2 under refraction
};

Facet facetBetween(vec3 n, vec3 wo, vec3 wi, float cosI, float eta) {
    Facet f;
    if (cosI > 0.0) {
        f.h = halfVector(n, wo, wi);
        f.cosine = min(0.5 * length(wo + wi), 1.0);
        f.jacobian = 1.0;
        return f;
    }
    vec3 m = wo + eta * wi;
    m = dot(n, m) < 0.0 ? -m : m;
    float m2 = dot(m, m);
    vec3 t = accurateCross(n, m);
    float c = dot(n, m);
    float s2 = dot(t, t);
    float scale = 1.0 / max(c * c + s2, 1e-30);
    f.h.cos2 = c * c * scale;
    f.h.sin2 = s2 * scale;
    f.h.slope = cross(t, n) * (c * scale);
    f.h.across = t * sqrt(scale);
    float perLength = inversesqrt(max(m2, 1e-30));
    float o = dot(wo, m) * perLength;
    float i = -dot(wi, m) * perLength;
    f.cosine = o > 0.0 && i > 0.0 ? min(o, 1.0) : 0.0;
    f.jacobian = 4.0 * o * i / max(m2, 1e-30);
    return f;
}

// f |cos|, and its derivatives; none by the normal.
vec3 roughDielectricCos(Surface s, vec3 normal, vec3 wo, vec3 wi, INOUT(BsdfDerivatives) d) {
    vec3 n = facing(normal, wo);
    float cosO = accurateDot(n, wo);
    float cosI = accurateDot(n, wi);
    if (!(min(cosO, abs(cosI)) > kMinCosine)) return vec3(0.0);
    float eta = indexBehind(s, normal, wo);
    Facet f = facetBetween(n, wo, wi, cosI, eta);
    if (!(f.cosine > 0.0)) return vec3(0.0);
    float alpha = surfaceAlpha(s);
    MicrofacetReflection g;
    if (IS_ANISOTROPIC(s))
        g = anisotropicReflection(s, n, wo, wi, cosO, abs(cosI), f.h);
    else if (IS_BECKMANN(s))
        g = beckmannReflection(alpha, n, wo, wi, cosO, abs(cosI), f.h);
    else
        g = ggxReflection(alpha, n, wo, wi, cosO, abs(cosI), f.h);
    Boundary b = dielectricBoundary(f.cosine, eta);
    bool reflects = cosI > 0.0;
    float term = (reflects ? b.reflected : b.transmitted) * f.jacobian;
    vec3 colour = reflects ? s.specularColor : s.baseColor;
    if (kDiffSpecular && reflects) d.at[kAtSpecular] = vec3(term * g.value);
    if (kDiffBaseColor && !reflects) d.at[kAtBaseColor] = vec3(term * g.value);
    if (kDiffRoughness) d.at[kAtRoughness] = colour * (term * g.alpha * surfaceAlphaDerivative(s));
    if (kDiffAnisotropy) d.at[kAtAnisotropy] = colour * (term * g.anisotropy);
    return colour * (term * g.value);
}

float roughDielectricPdf(Surface s, vec3 normal, vec3 wo, vec3 wi) {
    vec3 n = facing(normal, wo);
    float cosO = accurateDot(n, wo);
    float cosI = accurateDot(n, wi);
    if (!(min(cosO, abs(cosI)) > kMinCosine)) return 0.0;
    float eta = indexBehind(s, normal, wo);
    Facet f = facetBetween(n, wo, wi, cosI, eta);
    if (!(f.cosine > 0.0)) return 0.0;
    float probability = reflectionProbability(s, dielectricBoundary(f.cosine, eta));
    float chosen = cosI > 0.0 ? probability : (1.0 - probability) * eta * eta;
    return chosen * f.jacobian * microfacetPdf(s, n, wo, cosO, f.h);
}

// Draws wi with that density. False: it ends on the wrong side.
bool sampleRoughDielectric(Surface s, vec3 normal, vec3 wo, vec3 u, OUT(vec3) wi) {
    vec3 n = facing(normal, wo);
    float eta = indexBehind(s, normal, wo);
    vec3 x;
    vec3 y;
    vec2 alpha = microfacetFrame(s, n, x, y);
    vec3 o = vec3(dot(x, wo), dot(y, wo), dot(n, wo));
    vec3 h = sampleGgxNormal(alpha, o, vec2(u.x, u.y));
    float c = min(dot(o, h), 1.0);
    Boundary b = dielectricBoundary(max(c, 0.0), eta);
    bool reflects = u.z < reflectionProbability(s, b);
    vec3 local = reflects ? 2.0 * c * h - o : h * (c / eta - b.cosine) - o / eta;
    wi = normalize(local.x * x + local.y * y + local.z * n);
    float cosI = dot(n, wi);
    return c > 0.0 && (reflects ? cosI > kMinCosine : cosI < -kMinCosine && b.transmitted > 0.0);
}

// By what f is scaled where the face lets pass what the normal reflects, or the reverse: microfacets of a shading normal send light to the wrong side of the
// face. The face decides in which medium a path is, so radiance is scaled at each crossing of the face, and no path counts an index twice.
float faceScale(Surface s, vec3 normal, vec3 faceNormal, vec3 wo, vec3 wi) {
    return radianceScale(s, faceNormal, wo, wi) / radianceScale(s, normal, wo, wi);
}

#endif

// A smooth boundary between two dielectrics, or a thin pane: reflection and refraction in single directions.
//
// The normal points to the exterior. What is refracted is radiance: it is scaled by the squared relative index of refraction.
#ifndef CMPG_LIB_DIELECTRIC
#define CMPG_LIB_DIELECTRIC
#include "lib/surface.glsl"
#include "lib/fresnel.glsl"

// The index of refraction behind the surface, as seen from wo, over that in front. A pane is entered on both sides.
float indexBehind(Surface s, vec3 normal, vec3 wo) { return sideOf(normal, wo) < 0.0 && !IS_THIN(s) ? 1.0 / s.ior : s.ior; }

Boundary boundaryAt(Surface s, float c, float eta) {
    if (IS_THIN(s)) return paneBoundary(c, eta);
    return dielectricBoundary(c, eta);
}

// By what radiance is scaled on its way from wi to wo: 1 but for refraction.
float radianceScale(Surface s, vec3 normal, vec3 wo, vec3 wi) {
    if (!IS_DIELECTRIC(s) || IS_THIN(s) || dot(normal, wo) * dot(normal, wi) > 0.0) return 1.0;
    float eta = indexBehind(s, normal, wo);
    return 1.0 / (eta * eta);
}

// What is left of light after a way through an absorbing interior (Beer and Lambert's law).
vec3 interiorTransmittance(vec3 absorption, float distance) { return exp(-absorption * distance); }

// Where a ray from wo is refracted to; b as seen from wo's side, n the normal of that side.
vec3 refracted(Surface s, vec3 n, vec3 wo, float eta, Boundary b) {
    if (IS_THIN(s)) return -wo;
    return normalize(n * (dot(n, wo) / eta - b.cosine) - wo / eta);
}

// Of the energy that b does not absorb, by the colours: the probability of reflection. A colour that is asked for is not starved where it is black.
float reflectionProbability(Surface s, Boundary b) {
    float reflected = maxComponent(s.specularColor);
    float transmitted = maxComponent(s.baseColor);
    if (kDiffSpecular && asks(s, kSlotSpecular)) reflected = max(reflected, 0.25);
    if (kDiffBaseColor && asks(s, kSlotBaseColor)) transmitted = max(transmitted, 0.25);
    reflected = reflected * b.reflected;
    transmitted = transmitted * b.transmitted;
    return reflected > 0.0 ? reflected / (reflected + transmitted) : 0.0;
}

// The surface's normal, unless what it reflects or refracts would end on the wrong side of the face: then the face's own. Every crossing of the face is then a
// refraction, so that no path counts one side's index twice.
vec3 boundaryNormal(Surface s, vec3 normal, vec3 faceNormal, vec3 wo) {
    vec3 outward = dot(normal, faceNormal) < 0.0 ? -normal : normal;
    float side = sideOf(faceNormal, wo);
    vec3 n = outward * side;
    vec3 face = faceNormal * side;
    float c = dot(n, wo);
    if (!(c > kMinCosine)) return faceNormal;
    float eta = indexBehind(s, faceNormal, wo);
    Boundary b = boundaryAt(s, min(c, 1.0), eta);
    bool right = dot(face, 2.0 * c * n - wo) > 0.0 && (b.cosine == 0.0 || dot(face, refracted(s, n, wo, eta, b)) < 0.0);
    return right ? outward : faceNormal;
}

// What a smooth boundary carries from the single direction wi to wo, and derivatives.
vec3 smoothDielectric(Surface s, vec3 normal, vec3 wo, vec3 wi, OUT(BsdfDerivatives) d) {
    clear(d);
    vec3 n = facing(normal, wo);
    Boundary b = boundaryAt(s, min(dot(n, wo), 1.0), indexBehind(s, normal, wo));
    if (dot(n, wi) > 0.0) {
        if (kDiffSpecular) d.at[kAtSpecular] = vec3(b.reflected);
        return b.reflected * s.specularColor;
    }
    float passed = b.transmitted * radianceScale(s, normal, wo, wi);
    if (kDiffBaseColor) d.at[kAtBaseColor] = vec3(passed);
    return passed * s.baseColor;
}

// Draws one of the two directions of a smooth boundary with the probability returned; 0: there is none.
float sampleSmoothDielectric(Surface s, vec3 normal, vec3 wo, float u, OUT(vec3) wi) {
    vec3 n = facing(normal, wo);
    float eta = indexBehind(s, normal, wo);
    float c = min(dot(n, wo), 1.0);
    Boundary b = boundaryAt(s, c, eta);
    float probability = reflectionProbability(s, b);
    if (u < probability) {
        wi = normalize(2.0 * c * n - wo);
        return probability;
    }
    wi = refracted(s, n, wo, eta, b);
    return b.transmitted > 0.0 && (maxComponent(s.baseColor) > 0.0 || (kDiffBaseColor && asks(s, kSlotBaseColor))) ? 1.0 - probability : 0.0;
}

#endif

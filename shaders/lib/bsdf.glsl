// The surface material of glTF 2.0 (appendix B, KHR_materials_specular, KHR_materials_ior): value, density, sampling, derivatives.
//
//   mix(dielectric, metal, metallic), metal: GGX with Schlick F0 = baseColor,
//   dielectric: (1 - specular max(fr)) baseColor / pi + specular fr GGX, fr = f0 + (1 - f0) (1 - |w.h|)^5.
//
// Reflection only and two-sided: 0 where wo and wi are on different sides of the normal, and a normal that both are behind of is
// turned. All directions are unit vectors and point away from the surface.
//
// The includer defines the bool constants kLobeDiffuse, kLobeSpecular (a scene in which a lobe can contribute neither value nor
// derivative leaves it out) and kDiffBaseColor, kDiffRoughness, kDiffMetallic, kDiffSpecular, kDiffNormal (what is differentiated
// on some surface; a derivative that is switched off is 0). What a constant leaves out changes no bit of the rest: a lobe that a
// surface lacks adds an exact 0 where the constant keeps it in.
#ifndef CMPG_LIB_BSDF
#define CMPG_LIB_BSDF
#include "shared/material.h"
#include "lib/microfacet.glsl"
#include "lib/warp.glsl"

struct Surface {
    vec3 baseColor;     // [0,1]
    float roughness;    // [0,1]
    float metallic;     // [0,1]
    float specular;     // specularFactor, [0,1]
    vec3 specularColor; // specularColorFactor, >= 0
    float ior;          // 0 stands for infinity
    uint asked;         // bit per slot (kSlotBaseColor ...) whose derivative is asked for here
};

// Derivatives of f |cos| per colour channel.
struct BsdfDerivatives {
    vec3 baseColor; // channel c by baseColor channel c; the others are 0
    vec3 roughness;
    vec3 metallic;
    vec3 specular;
    // By the x, y, z of the unit normal in world space: the gradient of f(n / |n|), so it has no part along n.
    vec3 normalX;
    vec3 normalY;
    vec3 normalZ;
};

// Surfaces are two-sided: 1 where wo is on the side that the normal points to, -1 where it is behind.
float sideOf(vec3 normal, vec3 wo) { return dot(normal, wo) < 0.0 ? -1.0 : 1.0; }

// The normal of the side that wo is on.
vec3 facing(vec3 normal, vec3 wo) { return normal * sideOf(normal, wo); }

vec3 dielectricF0(Surface s) {
    float r = (1.0 - s.ior) / (1.0 + s.ior);
    return min(r * r * s.specularColor, vec3(1.0));
}

vec3 fresnel(vec3 f0, Schlick f) { return f0 * f.keep + vec3(f.grazing); }

bool asks(Surface s, uint slot) { return (s.asked >> slot & 1u) != 0u; }

// Lobes that can have a value or a wanted derivative somewhere.
bool hasDiffuse(Surface s) {
    bool coloured = maxComponent(s.baseColor) > 0.0;
    return kLobeDiffuse && ((s.metallic < 1.0 && (coloured || (kDiffBaseColor && asks(s, kSlotBaseColor)))) ||
                            (kDiffMetallic && asks(s, kSlotMetallic) && coloured));
}
bool hasSpecular(Surface s) {
    return kLobeSpecular && (s.metallic > 0.0 || (kDiffMetallic && asks(s, kSlotMetallic)) || s.specular > 0.0 ||
                             (kDiffSpecular && asks(s, kSlotSpecular)));
}

// Probability of drawing from the specular lobe, by the lobes' approximate albedo at cosO = |n.wo|. In [0.1, 0.9] where both
// lobes exist, so that neither is starved of samples: also not of those for a derivative where the value is 0.
float specularProbability(Surface s, float cosO) {
    if (!hasSpecular(s)) return 0.0;
    if (!hasDiffuse(s)) return 1.0;
    Schlick f;
    f.grazing = square(square(1.0 - cosO)) * (1.0 - cosO);
    f.keep = 1.0 - f.grazing;
    float fr = s.specular * maxComponent(fresnel(dielectricF0(s), f));
    float specular = mix(fr, maxComponent(fresnel(s.baseColor, f)), s.metallic);
    float diffuse = (1.0 - s.metallic) * (1.0 - fr) * maxComponent(s.baseColor);
    return clamp(specular / max(specular + diffuse, 1e-6), 0.1, 0.9);
}

// f |cos|, and its derivatives.
vec3 bsdfCosDerivatives(Surface s, vec3 normal, vec3 wo, vec3 wi, OUT(BsdfDerivatives) d) {
    vec3 zero = vec3(0.0);
    d.baseColor = zero;
    d.roughness = zero;
    d.metallic = zero;
    d.specular = zero;
    d.normalX = zero;
    d.normalY = zero;
    d.normalZ = zero;
    float side = sideOf(normal, wo);
    vec3 n = normal * side;
    float cosO = accurateDot(n, wo);
    float cosI = accurateDot(n, wi);
    if (!(min(cosO, cosI) > kMinCosine)) return zero;

    vec3 value = zero;
    vec3 gradientX = zero;
    vec3 gradientY = zero;
    vec3 gradientZ = zero;
    float dielectric = 1.0 - s.metallic;
    Schlick f;
    vec3 f0 = zero;
    vec3 fr = zero;
    float transmitted = 1.0; // 1 - specular max(fr)
    if (kLobeSpecular) {
        f = schlickWeights(wo, wi);
        f0 = dielectricF0(s);
        fr = fresnel(f0, f);
        if (s.specular != 0.0) transmitted = (1.0 - s.specular * maxComponent(f0)) * f.keep + (1.0 - s.specular) * f.grazing;
    }

    if (kLobeDiffuse) {
        float lambert = cosI * kInvPi;
        vec3 colour = dielectric * transmitted * s.baseColor;
        value = colour * lambert;
        if (kDiffBaseColor) d.baseColor = vec3(dielectric * transmitted * lambert);
        if (kDiffMetallic) d.metallic = -transmitted * lambert * s.baseColor;
        if (kDiffSpecular) d.specular = -dielectric * maxComponent(fr) * lambert * s.baseColor;
        if (kDiffNormal) {
            vec3 tangential = (wi - cosI * n) * kInvPi;
            gradientX = colour * tangential.x;
            gradientY = colour * tangential.y;
            gradientZ = colour * tangential.z;
        }
    }
    if (kLobeSpecular) {
        HalfVector h = halfVector(n, wo, wi);
        GgxReflection g = ggxReflection(alphaFromRoughness(s.roughness), n, wo, wi, cosO, cosI, h);
        vec3 reflected = dielectric * s.specular * fr + s.metallic * fresnel(s.baseColor, f);
        value = value + reflected * g.value;
        if (kDiffBaseColor) d.baseColor = d.baseColor + vec3(s.metallic * f.keep * g.value);
        if (kDiffRoughness) d.roughness = reflected * (g.alpha * alphaDerivative(s.roughness));
        if (kDiffMetallic) {
            // The difference of the two Fresnel terms, where they meet at grazing angles.
            vec3 difference = (s.baseColor - s.specular * f0) * f.keep + vec3((1.0 - s.specular) * f.grazing);
            d.metallic = d.metallic + difference * g.value;
        }
        if (kDiffSpecular) d.specular = d.specular + dielectric * fr * g.value;
        if (kDiffNormal) {
            gradientX = gradientX + reflected * g.normal.x;
            gradientY = gradientY + reflected * g.normal.y;
            gradientZ = gradientZ + reflected * g.normal.z;
        }
    }
    d.normalX = gradientX * side;
    d.normalY = gradientY * side;
    d.normalZ = gradientZ * side;
    return value;
}

// f |cos|.
vec3 bsdfCos(Surface s, vec3 n, vec3 wo, vec3 wi) {
    BsdfDerivatives unused; // the compiler drops what computes them
    return bsdfCosDerivatives(s, n, wo, wi, unused);
}

// Solid-angle density of sampleBsdf. Samples that end below the surface are not counted, so it integrates to at most 1.
float bsdfPdf(Surface s, vec3 normal, vec3 wo, vec3 wi) {
    vec3 n = facing(normal, wo);
    float cosO = accurateDot(n, wo);
    float cosI = accurateDot(n, wi);
    if (!(min(cosO, cosI) > kMinCosine)) return 0.0;
    float probability = specularProbability(s, cosO);
    float pdf = 0.0;
    if (hasDiffuse(s)) pdf = (1.0 - probability) * cosI * kInvPi;
    if (kLobeSpecular) pdf += probability * ggxPdf(alphaFromRoughness(s.roughness), cosO, halfVector(n, wo, wi));
    return pdf;
}

// Draws wi with density bsdfPdf; u in [0,1)^3, u.z picks the lobe. False: there is no direction (below the surface, or no lobe).
bool sampleBsdf(Surface s, vec3 normal, vec3 wo, vec3 u, OUT(vec3) wi) {
    vec3 n = facing(normal, wo);
    float cosO = accurateDot(n, wo);
    wi = n;
    if (!(cosO > kMinCosine) || !(hasDiffuse(s) || hasSpecular(s))) return false;
    vec3 x;
    vec3 y;
    orthonormalFrame(n, x, y);
    vec3 local;
    if (kLobeSpecular && u.z < specularProbability(s, cosO)) {
        vec3 o = vec3(dot(x, wo), dot(y, wo), cosO);
        vec3 h = sampleGgxNormal(alphaFromRoughness(s.roughness), o, vec2(u.x, u.y));
        local = 2.0 * dot(o, h) * h - o;
    } else {
        local = sampleCosineHemisphere(vec2(u.x, u.y));
    }
    wi = normalize(local.x * x + local.y * y + local.z * n);
    return dot(n, wi) > kMinCosine;
}

#endif

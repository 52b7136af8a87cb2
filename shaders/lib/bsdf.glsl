// The scattering of a surface: value, density, sampling, derivatives, put together from the lobes of its model (lib/lobes).
//
// Two-sided: a normal that wo is behind of is turned; dielectrics see another index of refraction from there, and surfaces that are black from behind
// scatter nothing. Where nothing is transmitted, f is 0 where wo
// and wi are on different sides of the normal; of a clear coat with a normal of its own, that one's. All directions are unit vectors and point away from the
// surface.
//
// Smooth boundaries scatter in single directions, in which no density can be evaluated: bsdfCos and bsdfPdf leave those out, sampleBsdf draws them with a
// probability instead, and singleCos says what one carries.
//
// The includer defines the bool constants kLobeDiffuse, kLobeSpecular of metallic-roughness (a scene in which a lobe can contribute neither value nor
// derivative leaves it out); kOtherModels, kMetallicRoughness, kDielectric, kConductor, kPlastic (some surface is of that model), kSmoothLobes, kRoughDielectric, kRoughReflection
// (conductors and plastics), kBeckmann, kGgx (their microfacets), kOneSided (some surface is black from behind), kCoatNormals (some clear coat has normals of its own); for each slot that scattering depends on kDiffBaseColor ... (it is differentiated on some
// surface), and kKeptSlots of lib/derivative_places.glsl, which has at least those. What a constant leaves out changes no bit of the rest: a lobe that a
// surface lacks adds an exact 0 where the constant keeps it in.
#ifndef CMPG_LIB_BSDF
#define CMPG_LIB_BSDF
#include "lib/surface.glsl"
#include "lib/lobes/anisotropy.glsl"
#include "lib/lobes/metallic_roughness.glsl"
#include "lib/lobes/sheen.glsl"
#include "lib/lobes/clear_coat.glsl"
#include "lib/lobes/reflection.glsl"
#include "lib/lobes/plastic.glsl"
#include "lib/lobes/dielectric.glsl"
#include "lib/lobes/rough_dielectric.glsl"

// Lobes that can have a value or a wanted derivative somewhere.
bool hasDiffuse(Surface s) {
    if (IS_METALLIC_ROUGHNESS(s)) return metallicRoughnessDiffuse(s);
    return IS_PLASTIC(s) && (maxComponent(s.baseColor) > 0.0 || (kDiffBaseColor && asks(s, kSlotBaseColor)));
}
bool hasSpecular(Surface s) {
    if (HAS_CLEAR_COAT(s)) return true;
    if (IS_METALLIC_ROUGHNESS(s)) return metallicRoughnessSpecular(s);
    return !IS_PLASTIC(s) || maxComponent(s.specularColor) > 0.0 || (kDiffSpecular && asks(s, kSlotSpecular));
}

// Probability of drawing from the boundary's reflection instead of the diffuse lobe, at cosO = |n.wo|.
float specularProbability(Surface s, float cosO) {
    if (IS_METALLIC_ROUGHNESS(s)) return metallicRoughnessProbability(s, cosO);
    if (!hasSpecular(s)) return 0.0;
    if (!hasDiffuse(s)) return 1.0;
    Boundary b = dielectricBoundary(min(cosO, 1.0), s.ior);
    float specular = b.reflected * maxComponent(s.specularColor);
    float diffuse = b.transmitted * maxComponent(s.baseColor);
    return clamp(specular / max(specular + diffuse, 1e-6), 0.1, 0.9);
}

// f |cos| of what scatters in all directions, and its derivatives.
vec3 bsdfCosDerivatives(Surface s, vec3 normal, vec3 wo, vec3 wi, OUT(BsdfDerivatives) d) {
    clear(d);
    if (IS_ROUGH_DIELECTRIC(s)) return roughDielectricCos(s, normal, wo, wi, d);
    vec3 value = vec3(0.0);
    float side = sideOf(normal, wo);
    vec3 n = normal * side;
    float cosO = accurateDot(n, wo);
    float cosI = accurateDot(n, wi);
    if (!(min(cosO, cosI) > kMinCosine)) {
        if (!kCoatNormals) return value;
        if (!HAS_COAT_NORMAL(s)) return value;
    }
    if (IS_BLACK_BEHIND(s) && side < 0.0) return value;
    if (!kCoatNormals || min(cosO, cosI) > kMinCosine) {
        if (kMetallicRoughness && IS_METALLIC_ROUGHNESS(s)) value = metallicRoughnessCos(s, n, wo, wi, cosO, cosI, d);
        if (HAS_SHEEN(s)) value = sheenOverCos(s, n, wo, wi, cosO, cosI, value, d);
    }
    if (HAS_CLEAR_COAT(s)) value = clearCoatedCos(s, n, wo, wi, cosO, cosI, value, d);
    if (IS_PLASTIC(s)) value = plasticBaseCos(s, n, wo, wi, cosO, cosI, d);
    if (kRoughReflection && (IS_PLASTIC(s) || IS_CONDUCTOR(s)) && !IS_SMOOTH(s))
        value = value + microfacetReflectionCos(s, n, wo, wi, cosO, cosI, d);
    if (kDiffNormal)
        for (uint k = 0u; k < 3u; ++k) d.at[kAtNormal + k] = d.at[kAtNormal + k] * side;
    return value;
}

// f |cos| of what scatters in all directions.
vec3 bsdfCos(Surface s, vec3 n, vec3 wo, vec3 wi) {
    BsdfDerivatives unused; // the compiler drops what computes them
    return bsdfCosDerivatives(s, n, wo, wi, unused);
}

// What the single direction wi that sampleBsdf drew with this normal carries, and derivatives. Those by the normal are left out: it moves the direction.
vec3 singleCosDerivatives(Surface s, vec3 normal, vec3 wo, vec3 wi, OUT(BsdfDerivatives) d) {
    if (IS_DIELECTRIC(s)) return smoothDielectric(s, normal, wo, wi, d);
    clear(d);
    vec3 term;
    vec3 reflected = boundaryReflected(s, min(abs(dot(normal, wo)), 1.0), term);
    addBoundaryDerivative(s, term, d);
    return reflected;
}

// Solid-angle density of sampleBsdf where it draws no single direction. Samples that end below the surface are not counted, so it integrates to at most 1.
float bsdfPdf(Surface s, vec3 normal, vec3 wo, vec3 wi) {
    if (IS_ROUGH_DIELECTRIC(s)) return roughDielectricPdf(s, normal, wo, wi);
    vec3 n = facing(normal, wo);
    float cosO = accurateDot(n, wo);
    float cosI = accurateDot(n, wi);
    if (!(min(cosO, cosI) > kMinCosine)) {
        if (!kCoatNormals) return 0.0;
        if (!HAS_COAT_NORMAL(s)) return 0.0;
    }
    if (IS_DIELECTRIC(s)) return 0.0;
    if (IS_BLACK_BEHIND(s) && dot(normal, wo) < 0.0) return 0.0;
    float pdf = 0.0;
    if (!kCoatNormals || min(cosO, cosI) > kMinCosine) {
        float probability = specularProbability(s, cosO);
        if (hasDiffuse(s)) pdf = (1.0 - probability) * cosI * kInvPi;
        if ((kLobeSpecular || kRoughReflection) && !IS_SMOOTH(s)) pdf += probability * microfacetPdf(s, n, wo, cosO, halfVector(n, wo, wi));
        if (HAS_SHEEN(s)) pdf = mix(pdf, cosI * kInvPi, sheenProbability(s, cosO));
    }
    if (HAS_CLEAR_COAT(s)) {
        vec3 coatN = n;
        float coatO = cosO;
        bool reflects = true;
        if (HAS_COAT_NORMAL(s)) {
            coatN = facing(s.coatNormal, wo);
            coatO = accurateDot(coatN, wo);
            reflects = min(coatO, accurateDot(coatN, wi)) > kMinCosine;
        }
        pdf = mix(pdf, reflects ? ggxPdf(clearCoatAlpha(s), coatO, halfVector(coatN, wo, wi)) : 0.0, clearCoatProbability(s, cosO, coatO));
    }
    return pdf;
}

// Draws wi; u in [0,1)^3, u.z picks the lobe. `single`: 0: with density bsdfPdf; else a single direction, with that probability. Beckmann's normals are
// drawn as GGX's of the same alpha, whose tails are longer. False: there is no direction (below the surface, or no lobe).
bool sampleBsdf(Surface s, vec3 normal, vec3 wo, vec3 u, OUT(vec3) wi, OUT(float) single) {
    vec3 n = facing(normal, wo);
    float cosO = accurateDot(n, wo);
    wi = n;
    single = 0.0;
    if (!(cosO > kMinCosine)) return false;
    if (IS_BLACK_BEHIND(s) && dot(normal, wo) < 0.0) return false;
    if (IS_ROUGH_DIELECTRIC(s)) return sampleRoughDielectric(s, normal, wo, u, wi);
    if (IS_DIELECTRIC(s)) {
        single = sampleSmoothDielectric(s, normal, wo, u.z, wi);
        return single > 0.0;
    }
    if (HAS_CLEAR_COAT(s)) {
        vec3 coatN = n;
        float coatO = cosO;
        if (HAS_COAT_NORMAL(s)) {
            coatN = facing(s.coatNormal, wo);
            coatO = accurateDot(coatN, wo);
        }
        float coat = clearCoatProbability(s, cosO, coatO);
        if (u.z < coat) return sampleClearCoat(s, coatN, wo, u, wi);
        u.z = (u.z - coat) / (1.0 - coat);
    }
    if (HAS_SHEEN(s)) {
        float sheen = sheenProbability(s, cosO);
        if (u.z < sheen) return sampleSheen(n, u, wi);
        u.z = (u.z - sheen) / (1.0 - sheen);
    }
    if (!(hasDiffuse(s) || hasSpecular(s))) return false;
    vec3 x;
    vec3 y;
    vec2 alpha = microfacetFrame(s, n, x, y);
    vec3 local;
    float probability = specularProbability(s, cosO);
    if ((kLobeSpecular || kOtherModels) && u.z < probability) {
        vec3 o = vec3(dot(x, wo), dot(y, wo), cosO);
        vec3 h = vec3(0.0, 0.0, 1.0);
        if (IS_SMOOTH(s))
            single = probability;
        else
            h = sampleGgxNormal(alpha, o, vec2(u.x, u.y));
        local = 2.0 * dot(o, h) * h - o;
    } else {
        local = sampleCosineHemisphere(vec2(u.x, u.y));
    }
    wi = normalize(local.x * x + local.y * y + local.z * n);
    return dot(n, wi) > kMinCosine;
}

#endif

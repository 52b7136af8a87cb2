// The surface material of glTF 2.0 (appendix B, KHR_materials_specular, KHR_materials_ior): a diffuse lobe and GGX reflection.
//
//   mix(dielectric, metal, metallic), metal: GGX with Schlick F0 = baseColor,
//   dielectric: (1 - specular max(fr)) baseColor / pi + specular fr GGX, fr = f0 + (1 - f0) (1 - |w.h|)^5.
#ifndef CMPG_LIB_METALLIC_ROUGHNESS
#define CMPG_LIB_METALLIC_ROUGHNESS
#include "lib/lobes/anisotropy.glsl"
#include "lib/warp.glsl"

vec3 dielectricF0(Surface s) {
    float r = (1.0 - s.ior) / (1.0 + s.ior);
    return min(r * r * s.specularColor, vec3(1.0));
}

vec3 fresnel(vec3 f0, Schlick f) { return f0 * f.keep + vec3(f.grazing); }

// Lobes that can have a value or a wanted derivative somewhere.
bool metallicRoughnessDiffuse(Surface s) {
    bool coloured = maxComponent(s.baseColor) > 0.0;
    return kLobeDiffuse && ((s.metallic < 1.0 && (coloured || (kDiffBaseColor && asks(s, kSlotBaseColor)))) ||
                            (kDiffMetallic && asks(s, kSlotMetallic) && coloured));
}
bool metallicRoughnessSpecular(Surface s) {
    return kLobeSpecular && (s.metallic > 0.0 || (kDiffMetallic && asks(s, kSlotMetallic)) || s.specular > 0.0 ||
                             (kDiffSpecular && asks(s, kSlotSpecular)));
}

// Probability of drawing from the specular lobe, by the lobes' approximate albedo at cosO = |n.wo|. In [0.1, 0.9] where both
// lobes exist, so that neither is starved of samples: also not of those for a derivative where the value is 0.
float metallicRoughnessProbability(Surface s, float cosO) {
    if (!metallicRoughnessSpecular(s)) return 0.0;
    if (!metallicRoughnessDiffuse(s)) return 1.0;
    Schlick f;
    f.grazing = square(square(1.0 - cosO)) * (1.0 - cosO);
    f.keep = 1.0 - f.grazing;
    float fr = s.specular * maxComponent(fresnel(dielectricF0(s), f));
    float specular = mix(fr, maxComponent(fresnel(s.baseColor, f)), s.metallic);
    float diffuse = (1.0 - s.metallic) * (1.0 - fr) * maxComponent(s.baseColor);
    return clamp(specular / max(specular + diffuse, 1e-6), 0.1, 0.9);
}

// f |cos|, and its derivatives; those by the normal in channels' gradients over unit normals n.
vec3 metallicRoughnessCos(Surface s, vec3 n, vec3 wo, vec3 wi, float cosO, float cosI, INOUT(BsdfDerivatives) d) {
    vec3 zero = vec3(0.0);
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
        if (kDiffBaseColor) d.at[kAtBaseColor] = vec3(dielectric * transmitted * lambert);
        if (kDiffMetallic) d.at[kAtMetallic] = -transmitted * lambert * s.baseColor;
        if (kDiffSpecular) d.at[kAtSpecular] = -dielectric * maxComponent(fr) * lambert * s.baseColor;
        if (kDiffNormal) {
            vec3 tangential = (wi - cosI * n) * kInvPi;
            gradientX = colour * tangential.x;
            gradientY = colour * tangential.y;
            gradientZ = colour * tangential.z;
        }
    }
    if (kLobeSpecular) {
        HalfVector h = halfVector(n, wo, wi);
        MicrofacetReflection g;
        if (IS_ANISOTROPIC(s))
            g = anisotropicReflection(s, n, wo, wi, cosO, cosI, h);
        else
            g = ggxReflection(alphaFromRoughness(s.roughness), n, wo, wi, cosO, cosI, h);
        vec3 reflected = dielectric * s.specular * fr + s.metallic * fresnel(s.baseColor, f);
        value = value + reflected * g.value;
        if (kDiffBaseColor) d.at[kAtBaseColor] = d.at[kAtBaseColor] + vec3(s.metallic * f.keep * g.value);
        if (kDiffRoughness) d.at[kAtRoughness] = reflected * (g.alpha * alphaDerivative(s.roughness));
        if (kDiffAnisotropy) d.at[kAtAnisotropy] = reflected * g.anisotropy;
        if (kDiffMetallic) {
            // The difference of the two Fresnel terms, where they meet at grazing angles.
            vec3 difference = (s.baseColor - s.specular * f0) * f.keep + vec3((1.0 - s.specular) * f.grazing);
            d.at[kAtMetallic] = d.at[kAtMetallic] + difference * g.value;
        }
        if (kDiffSpecular) d.at[kAtSpecular] = d.at[kAtSpecular] + dielectric * fr * g.value;
        if (kDiffNormal) {
            gradientX = gradientX + reflected * g.normal.x;
            gradientY = gradientY + reflected * g.normal.y;
            gradientZ = gradientZ + reflected * g.normal.z;
        }
    }
    if (kDiffNormal) {
        d.at[kAtNormal] = gradientX;
        d.at[kAtNormal + 1u] = gradientY;
        d.at[kAtNormal + 2u] = gradientZ;
    }
    return value;
}

#endif

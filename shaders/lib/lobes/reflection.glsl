// Reflection by the boundary of a conductor or of a plastic's coat, in a single direction or by microfacets.
#ifndef CMPG_LIB_REFLECTION
#define CMPG_LIB_REFLECTION
#include "lib/lobes/anisotropy.glsl"
#include "lib/fresnel.glsl"

vec3 conductorEta(Surface s) { return vec3(s.metallic, s.specular, s.ior); }

// What the boundary sends back at cosine c to its normal: Fresnel's term times the colour, and the term alone.
vec3 boundaryReflected(Surface s, float c, OUT(vec3) fresnelTerm) {
    vec3 colour = s.specularColor;
    fresnelTerm = vec3(0.0);
    if (IS_PLASTIC(s)) fresnelTerm = vec3(dielectricBoundary(c, s.ior).reflected);
    if (IS_CONDUCTOR(s)) {
        fresnelTerm = conductorReflected(c, conductorEta(s), s.specularColor);
        colour = s.baseColor;
    }
    return colour * fresnelTerm;
}

// The derivative by the colour that the boundary has.
void addBoundaryDerivative(Surface s, vec3 byColour, INOUT(BsdfDerivatives) d) {
    if (kDiffBaseColor && IS_CONDUCTOR(s)) d.at[kAtBaseColor] = d.at[kAtBaseColor] + byColour;
    if (kDiffSpecular && IS_PLASTIC(s)) d.at[kAtSpecular] = d.at[kAtSpecular] + byColour;
}

// f |cos| of the microfacets, added to `value`, and derivatives, added to d; those by the normal as gradients over unit normals n.
vec3 microfacetReflectionCos(Surface s, vec3 n, vec3 wo, vec3 wi, float cosO, float cosI, INOUT(BsdfDerivatives) d) {
    HalfVector h = halfVector(n, wo, wi);
    float alpha = surfaceAlpha(s);
    MicrofacetReflection g;
    if (IS_ANISOTROPIC(s))
        g = anisotropicReflection(s, n, wo, wi, cosO, cosI, h);
    else if (IS_BECKMANN(s))
        g = beckmannReflection(alpha, n, wo, wi, cosO, cosI, h);
    else
        g = ggxReflection(alpha, n, wo, wi, cosO, cosI, h);
    vec3 term;
    vec3 reflected = boundaryReflected(s, min(0.5 * length(wo + wi), 1.0), term);
    addBoundaryDerivative(s, term * g.value, d);
    if (kDiffRoughness) d.at[kAtRoughness] = d.at[kAtRoughness] + reflected * (g.alpha * surfaceAlphaDerivative(s));
    if (kDiffAnisotropy) d.at[kAtAnisotropy] = d.at[kAtAnisotropy] + reflected * g.anisotropy;
    if (kDiffNormal) addNormalDerivative(d, reflected, g.normal);
    return reflected * g.value;
}

#endif

// What a surface is made of at a point, and which way its normal counts.
#ifndef CMPG_LIB_SURFACE
#define CMPG_LIB_SURFACE
#include "shared/material.h"
#include "lib/derivative_places.glsl"
#include "lib/microfacet.glsl"

// The slots of SurfaceModel (src/scene/scene.h); of other models than glTF's metallic-roughness some fields hold other things.
struct Surface {
    vec3 baseColor;     // [0,1]
    float roughness;    // [0,1]
    float metallic;     // [0,1]; conductor: eta.x; smooth plastic: what the coat reflects of diffuse light from within
    float specular;     // specularFactor, [0,1]; conductor: eta.y; rough plastic: the first texel of its table
    vec3 specularColor; // specularColorFactor, >= 0; dielectrics and plastic: the specular slot, [0,1]; conductor: k
    float ior;          // 0 stands for infinity; dielectrics and plastic: interior over exterior; conductor: eta.z
    uint asked;         // bit per slot (kSlotBaseColor ...) whose derivative is asked for here
    uint model;         // GpuMaterial::flags
    float lobe[kLobeSlots] ZEROED; // the LOBE_SLOTs, as far as the material has them
    vec3 tangent ZEROED; // of anisotropic microfacets: the direction of alpha_t, before the normal is taken off it
    vec3 sheenColor ZEROED; // [0,1]
    vec3 coatNormal ZEROED; // of a clear coat with normals of its own, unit; zero: it has those of what is below
};

// Derivatives of f |cos| per colour channel, by place: kAtBaseColor ... where the slot is differentiated (kDiffBaseColor ...).
// Of a colour: channel c by channel c; the others are 0. kAtNormal and the next two: by x, y, z of the unit normal in world space, the gradient of
// f(n / |n|), so it has no part along n.
struct BsdfDerivatives {
    vec3 at[kDerivativePlaces];
};

// GLSL does not assign structs like this one.
void clear(OUT(BsdfDerivatives) d) {
    for (uint k = 0u; k < kDerivativePlaces; ++k) d.at[k] = vec3(0.0);
}

// Adds channels' gradients over normals, one row for each of x, y and z.
void addNormalDerivative(INOUT(BsdfDerivatives) d, vec3 channels, vec3 gradient) {
    d.at[kAtNormal] = d.at[kAtNormal] + channels * gradient.x;
    d.at[kAtNormal + 1u] = d.at[kAtNormal + 1u] + channels * gradient.y;
    d.at[kAtNormal + 2u] = d.at[kAtNormal + 2u] + channels * gradient.z;
}

// 1 where wo is on the side that the normal points to, -1 where it is behind.
float sideOf(vec3 normal, vec3 wo) { return dot(normal, wo) < 0.0 ? -1.0 : 1.0; }

// The normal of the side that wo is on.
vec3 facing(vec3 normal, vec3 wo) { return normal * sideOf(normal, wo); }

bool asks(Surface s, uint slot) { return (s.asked >> slot & 1u) != 0u; }

uint modelOf(Surface s) { return s.model >> kModelShift & kModelMask; }

// Macros, not functions: where kernels are specialised, constants within a call do not fold what depends on its result.
#define IS_METALLIC_ROUGHNESS(s) (!kOtherModels || modelOf(s) == kModelMetallicRoughness)
#define IS_DIELECTRIC(s) (kDielectric && (modelOf(s) == kModelDielectric || modelOf(s) == kModelThinDielectric))
#define IS_THIN(s) (modelOf(s) == kModelThinDielectric)
#define IS_CONDUCTOR(s) (kConductor && modelOf(s) == kModelConductor)
#define IS_PLASTIC(s) (kPlastic && modelOf(s) == kModelPlastic)
#define IS_SMOOTH(s) (kSmoothLobes && ((s).model & kMaterialSmooth) != 0u)
#define IS_ROUGH_DIELECTRIC(s) (kRoughDielectric && modelOf(s) == kModelDielectric && !IS_SMOOTH(s))
#define IS_BLACK_BEHIND(s) (kOneSided && ((s).model & kMaterialOneSided) != 0u)
#define IS_BECKMANN(s) (kBeckmann && (!kGgx || ((s).model & kMaterialBeckmann) != 0u))

// Of the microfacets; 0 where the boundary is smooth.
float surfaceAlpha(Surface s) {
    if (IS_METALLIC_ROUGHNESS(s)) return alphaFromRoughness(s.roughness);
    if (IS_SMOOTH(s)) return 0.0;
    return (s.model & kMaterialAlphaSquared) != 0u ? alphaFromRoughness(s.roughness) : max(s.roughness, kMinAlpha);
}
// By the roughness slot; not for metallic-roughness.
float surfaceAlphaDerivative(Surface s) {
    if ((s.model & kMaterialAlphaSquared) != 0u) return alphaDerivative(s.roughness);
    return s.roughness > kMinAlpha ? 1.0 : 0.0;
}

#endif

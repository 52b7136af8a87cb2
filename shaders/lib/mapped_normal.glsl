// Normals of a normal map that the eye could not see.
#ifndef CMPG_LIB_MAPPED_NORMAL
#define CMPG_LIB_MAPPED_NORMAL
#include "lib/surface.glsl"

// The least cosine with wo of a mapped normal. At grazing angles a map turns more normals from wo than a real relief would show there: its slopes hide each
// other. Such a normal would have what is below the surface to reflect, which is dark.
const float kLeastMappedCosine = 0.01;

bool turnedFrom(vec3 own, vec3 mapped, vec3 wo) { return dot(mapped, wo) * sideOf(own, wo) < kLeastMappedCosine; }

// Not of unit length.
vec3 tilted(vec3 own, vec3 mapped, vec3 wo) { return mapped + wo * (sideOf(own, wo) * kLeastMappedCosine - dot(mapped, wo)); }

// The mapped normal; one that turns from wo, seen from the side of the surface's own normal that wo is on, is tilted towards wo until the cosine is about the
// least. All unit vectors; continuous in `mapped`.
vec3 visibleNormal(vec3 own, vec3 mapped, vec3 wo) {
    if (!turnedFrom(own, mapped, wo)) return mapped;
    return normalize(tilted(own, mapped, wo));
}

// d holds the gradient by visibleNormal(own, mapped, wo), without a part along it, and then that by `mapped`.
void fromVisibleNormal(vec3 own, vec3 mapped, vec3 wo, INOUT(BsdfDerivatives) d) {
    if (!turnedFrom(own, mapped, wo)) return;
    // The normal is v / |v|, v = mapped - wo dot(mapped, wo) + a constant: a gradient loses its part along wo, and is divided by |v|.
    vec3 v = tilted(own, mapped, wo);
    float inverseLength = inversesqrt(dot(v, v));
    vec3 along = wo.x * d.at[kAtNormal] + wo.y * d.at[kAtNormal + 1u] + wo.z * d.at[kAtNormal + 2u];
    d.at[kAtNormal] = (d.at[kAtNormal] - wo.x * along) * inverseLength;
    d.at[kAtNormal + 1u] = (d.at[kAtNormal + 1u] - wo.y * along) * inverseLength;
    d.at[kAtNormal + 2u] = (d.at[kAtNormal + 2u] - wo.z * along) * inverseLength;
}
#endif

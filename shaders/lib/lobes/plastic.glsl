// The diffuse base under the dielectric coat of a plastic: light goes in through the coat, to and fro between base and coat, and out.
//
//   f = baseColor / (1 - r baseColor) T(wo) T(wi) / (pi eta^2),
//
// T: what the coat lets through, r: what it reflects of diffuse light from within; linear: 1 - r instead of 1 - r baseColor. Rough coats have T and r
// in a table (src/scene/coat_table.h). The includer defines vec4 coatTexel(uint at).
#ifndef CMPG_LIB_PLASTIC
#define CMPG_LIB_PLASTIC
#include "lib/surface.glsl"
#include "lib/fresnel.glsl"
#include "lib/warp.glsl"

// A value of the coat, and its derivatives.
struct Coat {
    float value;
    float alpha;
    float cosine;
};

// Row and place in it of alpha.
vec2 coatRow(float alpha) {
    float at = sqrt(alpha) * float(kCoatRows);
    float row = min(floor(at), float(kCoatRows - 1u));
    return vec2(row, at - row);
}

Coat coatTransmitted(Surface s, float alpha, float c) {
    Coat t;
    if (IS_SMOOTH(s)) {
        Boundary b = dielectricBoundary(c, s.ior);
        t.value = b.transmitted;
        t.alpha = 0.0;
        t.cosine = transmittedDerivative(c, s.ior, b);
        return t;
    }
    float cells = float(kCoatColumns - 1u);
    float column = min(floor(c * cells), cells - 1.0);
    float x = c * cells - column;
    vec2 row = coatRow(alpha);
    vec4 v = coatTexel(uint(s.specular) + uint(row.x) * kCoatColumns + uint(column));
    float low = v.x + x * (v.y - v.x);
    float high = v.z + x * (v.w - v.z);
    t.value = low + row.y * (high - low);
    t.alpha = (high - low) * float(kCoatRows) * 0.5 * inversesqrt(alpha);
    t.cosine = ((v.y - v.x) * (1.0 - row.y) + (v.w - v.z) * row.y) * cells;
    return t;
}

// What the coat reflects of diffuse light from within.
Coat coatReflectedWithin(Surface s, float alpha) {
    Coat r;
    r.value = s.metallic;
    r.alpha = 0.0;
    r.cosine = 0.0;
    if (IS_SMOOTH(s)) return r;
    vec2 row = coatRow(alpha);
    vec4 v = coatTexel(uint(s.specular) + uint(row.x) * kCoatColumns + kCoatColumns - 1u);
    r.value = v.x + row.y * (v.z - v.x);
    r.alpha = (v.z - v.x) * float(kCoatRows) * 0.5 * inversesqrt(alpha);
    return r;
}

// f |cos|, added to `value` by the caller, and derivatives, added to d.
vec3 plasticBaseCos(Surface s, vec3 n, vec3 wo, vec3 wi, float cosO, float cosI, INOUT(BsdfDerivatives) d) {
    float alpha = surfaceAlpha(s);
    Coat o = coatTransmitted(s, alpha, cosO);
    Coat i = coatTransmitted(s, alpha, cosI);
    Coat r = coatReflectedWithin(s, alpha);
    bool nonlinear = (s.model & kMaterialNonlinear) != 0u;
    vec3 darkened = nonlinear ? s.baseColor : vec3(1.0);
    vec3 series = 1.0 / (vec3(1.0) - r.value * darkened);
    float scale = kInvPi / (s.ior * s.ior);
    float passed = o.value * i.value * cosI * scale;
    vec3 colour = s.baseColor * series;
    if (kDiffBaseColor) d.at[kAtBaseColor] = d.at[kAtBaseColor] + passed * series * (nonlinear ? series : vec3(1.0));
    if (kDiffRoughness) {
        float change = (o.alpha * i.value + o.value * i.alpha) * cosI * scale;
        d.at[kAtRoughness] = d.at[kAtRoughness] + colour * (vec3(change) + passed * r.alpha * darkened * series) * surfaceAlphaDerivative(s);
    }
    if (kDiffNormal) {
        vec3 gradient = (wo - cosO * n) * (o.cosine * i.value * cosI * scale) + (wi - cosI * n) * (o.value * (i.cosine * cosI + i.value) * scale);
        addNormalDerivative(d, colour, gradient);
    }
    return colour * passed;
}

#endif

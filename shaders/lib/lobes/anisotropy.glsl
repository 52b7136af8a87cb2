// Microfacets that are rougher along one direction of the surface than across it: GGX or Beckmann's with two alphas, Smith masking separable.
//
//   D = 1 / (pi at ab ((h.t / at)^2 + (h.b / ab)^2 + (n.h)^2)^2) of GGX, with t the direction in the plane of n, b = n x t,
//   KHR_materials_anisotropy: ab = alpha, at = alpha + anisotropy^2 (1 - alpha); models whose roughness is alpha: ab = roughness, at = anisotropy;
//   by aspect (Burley 2012): at = alpha / aspect, ab = alpha aspect, aspect = sqrt(1 - 0.9 anisotropy).
//
// What is said of accuracy in microfacet.glsl holds here, with r(w) = sqrt((at w.t)^2 + (ab w.b)^2 + (n.w)^2).
#ifndef CMPG_LIB_ANISOTROPY
#define CMPG_LIB_ANISOTROPY
#include "lib/surface.glsl"

// The includer defines kTexturedAnisotropy: some material has such microfacets.
#define IS_ANISOTROPIC(s) (kTexturedAnisotropy && ((s).model & kMaterialAnisotropic) != 0u && !IS_PLASTIC(s))
#define ANISOTROPY(s) ((s).lobe[kSlotAnisotropy - kCommonSlots])

bool hasTwoAlphas(Surface s) { return !IS_METALLIC_ROUGHNESS(s) && (s.model & kMaterialAlphaSquared) == 0u; }
bool hasAspect(Surface s) { return IS_METALLIC_ROUGHNESS(s) && (s.model & kMaterialAspect) != 0u; }
float aspectOf(float anisotropy) { return sqrt(1.0 - 0.9 * anisotropy); }

// Along t and b.
vec2 anisotropicAlphas(Surface s) {
    float alpha = surfaceAlpha(s);
    float anisotropy = ANISOTROPY(s);
    if (hasTwoAlphas(s)) return vec2(max(anisotropy, kMinAlpha), alpha);
    if (hasAspect(s)) return vec2(alpha / aspectOf(anisotropy), max(alpha * aspectOf(anisotropy), kMinAlpha));
    return vec2(alpha + anisotropy * anisotropy * (1.0 - alpha), alpha);
}

// The narrower one where there are two.
float smallestAlpha(Surface s) {
    float alpha = surfaceAlpha(s);
    if (IS_ANISOTROPIC(s)) {
        vec2 both = anisotropicAlphas(s);
        alpha = min(both.x, both.y);
    }
    return alpha;
}

struct AnisotropicFrame {
    vec3 t;
    vec3 b;
    float twist; // how far t turns towards b while n moves by one along b
};

AnisotropicFrame anisotropicFrame(Surface s, vec3 n) {
    AnisotropicFrame f;
    float along = dot(n, s.tangent);
    vec3 t = s.tangent - along * n;
    float length2 = dot(t, t);
    if (!(length2 > 1e-8)) { // n stands on the direction
        orthonormalFrame(n, f.t, f.b);
        f.twist = 0.0;
        return f;
    }
    float scale = inversesqrt(length2);
    f.t = t * scale;
    f.b = cross(n, f.t);
    f.twist = -along * scale;
    return f;
}

// The frame in which half vectors are drawn, its z being n, and alpha along its x and y.
vec2 microfacetFrame(Surface s, vec3 n, OUT(vec3) x, OUT(vec3) y) {
    if (IS_ANISOTROPIC(s)) {
        AnisotropicFrame f = anisotropicFrame(s, n);
        x = f.t;
        y = f.b;
        return anisotropicAlphas(s);
    }
    orthonormalFrame(n, x, y);
    return vec2(surfaceAlpha(s));
}

// (h.t, h.b) of the unit half vector, from n x h, which keeps its relative accuracy.
vec2 halfAlong(AnisotropicFrame f, HalfVector h) { return vec2(dot(h.across, f.b), -dot(h.across, f.t)); }

// r(w) of GGX, w = (w.t, w.b, n.w).
float anisotropicRoot(vec2 alpha, vec3 w) {
    vec2 stretched = vec2(alpha.x * w.x, alpha.y * w.y);
    return sqrt(dot(stretched, stretched) + w.z * w.z);
}

// at ab ((h.t / at)^2 + (h.b / ab)^2 + (n.h)^2), with the first two terms.
vec3 anisotropicSquare(vec2 alpha, vec2 along, float cos2) {
    float ratio = alpha.y / alpha.x;
    float t = along.x * along.x * ratio;
    float b = along.y * along.y / ratio;
    return vec3(t, b, t + b + alpha.x * alpha.y * cos2);
}

// Solid-angle density of reflected visible normals of GGX.
float anisotropicPdf(Surface s, vec3 n, vec3 wo, float cosO, HalfVector h) {
    AnisotropicFrame f = anisotropicFrame(s, n);
    vec2 alpha = anisotropicAlphas(s);
    float q = anisotropicSquare(alpha, halfAlong(f, h), h.cos2).z;
    float root = anisotropicRoot(alpha, vec3(dot(f.t, wo), dot(f.b, wo), cosO));
    return alpha.x * alpha.y * kInvPi / (q * q) / (2.0 * (cosO + root));
}

float microfacetPdf(Surface s, vec3 n, vec3 wo, float cosO, HalfVector h) {
    if (IS_ANISOTROPIC(s)) return anisotropicPdf(s, n, wo, cosO, h);
    return ggxPdf(surfaceAlpha(s), cosO, h);
}

// A value and its derivatives: by both alphas, and by how n, t and b turn: n towards t, n towards b, t towards b about n.
struct TwoAlphas {
    float value;
    vec2 alpha;
    vec3 turn;
};

// D G / (4 cosO cosI) * cosI of GGX; o, i: (w.t, w.b, n.w), above the surface.
TwoAlphas anisotropicGgx(vec2 alpha, vec3 o, vec3 i, vec2 along, float cos2) {
    vec2 a2 = alpha * alpha;
    vec2 b2 = vec2((1.0 - alpha.x) * (1.0 + alpha.x), (1.0 - alpha.y) * (1.0 + alpha.y));
    vec3 q = anisotropicSquare(alpha, along, cos2);
    float rO = anisotropicRoot(alpha, o);
    float rI = anisotropicRoot(alpha, i);
    float perO = 1.0 / (rO * (o.z + rO));
    float perI = 1.0 / (rI * (i.z + rI));
    float dv = alpha.x * alpha.y * kInvPi / (q.z * q.z) / ((o.z + rO) * (i.z + rI));
    TwoAlphas g;
    g.value = dv * i.z;
    float rest = q.z - q.x - q.y; // at ab (n.h)^2
    vec2 byD = vec2(3.0 * q.x - q.y - rest, 3.0 * q.y - q.x - rest) / (alpha * q.z);
    g.alpha = g.value * (byD - alpha * vec2(o.x * o.x * perO + i.x * i.x * perI, o.y * o.y * perO + i.y * i.y * perI));
    float ratio = alpha.y / alpha.x;
    float c = sqrt(cos2);
    vec2 tilt = vec2(along.x * ratio * b2.x, along.y / ratio * b2.y) * (4.0 * c / q.z)
              - vec2(o.x * (rO + b2.x * o.z), o.y * (rO + b2.y * o.z)) * perO;
    // The factor n.wi turns 1 - (...) into what has no difference of nearly equal numbers.
    vec2 tiltI = vec2(i.x * (a2.x * (i.x * i.x + i.z * i.z) + a2.y * i.y * i.y), i.y * (a2.x * i.x * i.x + a2.y * (i.y * i.y + i.z * i.z))) * perI;
    float twist = along.x * along.y * (1.0 / ratio - ratio) * (4.0 / q.z) - (a2.x - a2.y) * (o.x * o.y * perO + i.x * i.y * perI);
    g.turn = vec3(g.value * tilt + dv * tiltI, g.value * twist);
    return g;
}

// Masking of Beckmann's normals, in Walter's rational approximation: G1(w) / (2 n.w), and derivatives of its logarithm.
TwoAlphas anisotropicMasking(vec2 alpha, vec3 w) {
    TwoAlphas v;
    vec2 along = vec2(w.x, w.y);
    vec2 stretched = alpha * along;
    float p2 = dot(stretched, stretched);
    v.value = 0.5 / w.z;
    v.alpha = vec2(0.0);
    v.turn = vec3(along * (-1.0 / w.z), 0.0);
    if (w.z * w.z >= 2.56 * p2) return v; // a >= 1.6: nothing is masked
    // With p = |(at w.t, ab w.b)| and a = n.w / p: G1 / (n.w) = f(a) / p.
    float perP = inversesqrt(p2);
    float a = w.z * perP;
    float top = 3.535 + 2.181 * a;
    float over = 1.0 / (1.0 + a * (2.276 + 2.577 * a));
    float slope = 2.181 / top - (2.276 + 5.154 * a) * over; // d ln f / d a
    vec2 squares = stretched * stretched * (perP * perP);
    vec3 turn = perP * perP * vec3(alpha * stretched * -w.z, (alpha.x - alpha.y) * (alpha.x + alpha.y) * w.x * w.y); // of ln p
    v.value = 0.5 * perP * top * over;
    v.alpha = squares / alpha * (-1.0 - slope * a);
    v.turn = turn * (-1.0 - slope * a) + vec3(along * (slope * perP), 0.0);
    return v;
}

// As anisotropicGgx, of Beckmann's microfacets.
TwoAlphas anisotropicBeckmann(vec2 alpha, vec3 o, vec3 i, vec2 along, float cos2) {
    TwoAlphas g;
    g.value = 0.0;
    g.alpha = vec2(0.0);
    g.turn = vec3(0.0);
    if (!(cos2 > 1e-8)) return g; // exp(-1e8)
    vec2 perAlpha2 = 1.0 / (alpha * alpha);
    vec2 steep = along * along * perAlpha2 / cos2;
    float d = exp(-steep.x - steep.y) * kInvPi / (alpha.x * alpha.y * cos2 * cos2);
    if (!(d > 0.0)) return g;
    TwoAlphas vO = anisotropicMasking(alpha, o);
    TwoAlphas vI = anisotropicMasking(alpha, i);
    float dv = d * vO.value * vI.value;
    g.value = dv * i.z;
    g.alpha = g.value * ((2.0 * steep - vec2(1.0)) / alpha + vO.alpha + vI.alpha);
    vec2 tilt = along * inversesqrt(cos2) * 2.0 * (perAlpha2 + vec2(steep.x + steep.y - 2.0));
    float twist = -2.0 * along.x * along.y * (perAlpha2.x - perAlpha2.y) / cos2;
    g.turn = g.value * (vec3(tilt, twist) + vO.turn + vI.turn) + vec3(dv * vec2(i.x, i.y), 0.0);
    return g;
}

// As ggxReflection and beckmannReflection. wi may be behind the surface where it refracts: cosI is |n.wi|, and what is wanted then has no derivative by the normal.
MicrofacetReflection anisotropicReflection(Surface s, vec3 n, vec3 wo, vec3 wi, float cosO, float cosI, HalfVector h) {
    AnisotropicFrame f = anisotropicFrame(s, n);
    vec2 alpha = anisotropicAlphas(s);
    vec3 o = vec3(dot(f.t, wo), dot(f.b, wo), cosO);
    vec3 i = vec3(dot(f.t, wi), dot(f.b, wi), cosI);
    vec2 along = halfAlong(f, h);
    TwoAlphas two;
    if (IS_BECKMANN(s) && !IS_METALLIC_ROUGHNESS(s))
        two = anisotropicBeckmann(alpha, o, i, along, h.cos2);
    else
        two = anisotropicGgx(alpha, o, i, along, h.cos2);
    MicrofacetReflection g;
    g.value = two.value;
    float anisotropy = ANISOTROPY(s);
    if (hasTwoAlphas(s)) {
        g.alpha = two.alpha.y;
        g.anisotropy = anisotropy > kMinAlpha ? two.alpha.x : 0.0;
    } else if (hasAspect(s)) {
        float aspect = aspectOf(anisotropy);
        float across = surfaceAlpha(s) * aspect > kMinAlpha ? two.alpha.y : 0.0;
        g.alpha = two.alpha.x / aspect + across * aspect;
        g.anisotropy = (two.alpha.x * alpha.x / aspect - across * alpha.y / aspect) * (0.45 / aspect);
    } else {
        g.alpha = two.alpha.x * (1.0 - anisotropy * anisotropy) + two.alpha.y;
        g.anisotropy = two.alpha.x * (2.0 * anisotropy * (1.0 - alpha.y));
    }
    g.normal = f.t * two.turn.x + f.b * (two.turn.y + f.twist * two.turn.z);
    return g;
}

#endif

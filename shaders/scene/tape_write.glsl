// Derivatives of one scattering decision with respect to the values its slots hold at this point, and their record on the tape.
// Expects what scene/vertex.glsl expects.

void scaleDerivatives(INOUT(BsdfDerivatives) d, vec3 s) {
    for (uint k = 0; k < kDerivativePlaces; ++k) d.at[k] *= s;
}

// Sum over the parameters of the absolute derivatives of each channel (a look-up's weights add up to 1); sign: only of this sign.
vec3 derivativeNorm(BsdfDerivatives d, int sign) {
    vec3 sum = vec3(0);
    for (uint k = 0; k < kDerivativePlaces; ++k) sum += sign == 0 ? abs(d.at[k]) : max(float(sign) * d.at[k], vec3(0));
    return sum;
}

bool anyDerivative(BsdfDerivatives d) { return any(greaterThan(derivativeNorm(d, 0), vec3(0))); }

// Derivatives by the unit normal seen from wo become those by the looked-up tangent-space vector t.
void toTangentSpace(SurfacePoint p, vec3 wo, INOUT(BsdfDerivatives) d) {
    // n = frame t / |t|: df/dt = (1 - t t^T / |t|^2) frame^T df/dn / |t|.
    mat3 frame;
    vec3 t;
    float inverseLength;
    const vec3 mapped = mappedNormal(p, kFrozen ? scene.secondTexels : 0, frame, t, inverseLength);
    fromVisibleNormal(p.normal, mapped, wo, d);
    const vec3 nx = d.at[kAtNormal], ny = d.at[kAtNormal + 1], nz = d.at[kAtNormal + 2];
    const vec3 x = frame[0].x * nx + frame[0].y * ny + frame[0].z * nz;
    const vec3 y = frame[1].x * nx + frame[1].y * ny + frame[1].z * nz;
    const vec3 z = frame[2].x * nx + frame[2].y * ny + frame[2].z * nz;
    const vec3 radial = t.x * x + t.y * y + t.z * z;
    d.at[kAtNormal] = (x - t.x * radial) * inverseLength;
    d.at[kAtNormal + 1] = (y - t.y * radial) * inverseLength;
    d.at[kAtNormal + 2] = (z - t.z * radial) * inverseLength;
}

// f |cos| and its derivatives, by the values that the slots hold here; slots of this material nobody asked for stay zero. Those by the normal are by
// the looked-up tangent-space vector. `single`: of a single direction, drawn with `drawnBy` as the normal.
vec3 scatterDerivatives(SurfacePoint p, SurfaceMaterial m, vec3 drawnBy, vec3 wo, vec3 wi, bool single, OUT(BsdfDerivatives) d) {
    vec3 f;
    if (kSmoothLobes && single)
        f = singleCosDerivatives(m.surface, drawnBy, wo, wi, d);
    else
        f = bsdfCosDerivatives(m.surface, m.normal, wo, wi, d);
    if (IS_ROUGH_DIELECTRIC(m.surface)) {
        const float scale = faceScale(m.surface, m.normal, p.faceNormal, wo, wi);
        f *= scale;
        scaleDerivatives(d, vec3(scale));
    }
    if (kBlend) scaleDerivatives(d, vec3(m.share));
    const uint asked = m.surface.asked;
#define SURFACE_SLOT(number, Name, name, channels, highest, adam, sgd) \
    if (kDiff##Name && (asked & (1u << number)) == 0) d.at[kAt##Name] = vec3(0);
#define LOBE_COLOR_SLOT(number, Name, name, channels, highest, adam, sgd, extension, factor, standard, texture, channel) \
    if (kDiff##Name && (asked & (1u << number)) == 0) \
        for (uint k = 0; k < 3; ++k) d.at[kAt##Name + k] = vec3(0);
#include "shared/slots.def"
    if (kDiffBaseColor) d.at[kAtBaseColor] *= m.colorFactor;
    if (kDiffNormal) {
        if ((asked & (1u << kSlotNormal)) != 0)
            toTangentSpace(p, wo, d);
        else
            for (uint k = 0; k < 3; ++k) d.at[kAtNormal + k] = vec3(0);
    }
    if (kDiffWeight) d.at[kAtWeight] = (m.flags & kMaterialWeightDifferentiated) != 0 ? p.blend * f : vec3(0);
    return kBlend ? m.share * f : f;
}

// The value alone.
vec3 scattered(SurfacePoint p, SurfaceMaterial m, vec3 drawnBy, vec3 wo, vec3 wi, bool single) {
    BsdfDerivatives unused; // the compiler drops what computes them
    vec3 f;
    if (kSmoothLobes && single)
        f = singleCosDerivatives(m.surface, drawnBy, wo, wi, unused);
    else
        f = bsdfCos(m.surface, m.normal, wo, wi);
    if (IS_ROUGH_DIELECTRIC(m.surface)) f *= faceScale(m.surface, m.normal, p.faceNormal, wo, wi);
    return kBlend ? m.share * f : f;
}

// plane: kPlaneDrawn, dw_i; kPlaneLit: dN_i before visibility.
void tapeDerivatives(uint slot, uint plane, BsdfDerivatives d) {
    for (uint k = 0; k < kDerivativeCount; ++k) tapePut3(slot, plane + kTapeDerivative * k, d.at[k]);
}

void tapeNoDerivatives(uint slot, uint plane) {
    for (uint k = 0; k < kDerivativeCount; ++k) tapePut3(slot, plane + kTapeDerivative * k, vec3(0));
}

void tapeLight(uint slot, bool valid, LightSample light, vec3 factor) {
    tape[kPlaneLight * push.count + slot] = light.material;
    tapePut(slot, kPlaneLight + 1, light.uv0.x);
    tapePut(slot, kPlaneLight + 2, light.uv0.y);
    tapePut3(slot, kPlaneLight + 3, valid ? factor : vec3(0));
    if (kTexcoord1) {
        tapePut(slot, kPlaneLight + 6, light.uv1.x);
        tapePut(slot, kPlaneLight + 7, light.uv1.y);
    }
}

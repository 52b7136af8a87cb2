// Derivatives of one scattering decision with respect to the values its slots hold at this point, and their record on the tape.
// Expects what scene/vertex.glsl expects.

struct SlotDerivatives {
    vec3 baseColor; // of each channel with respect to the same channel
    vec3 roughness, metallic, specular;
    vec3 normalX, normalY, normalZ; // with respect to the looked-up tangent-space vector
};

SlotDerivatives noSlotDerivatives() { return SlotDerivatives(vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0), vec3(0)); }

void scaleSlotDerivatives(INOUT(SlotDerivatives) d, vec3 s) {
    d.baseColor *= s;
    d.roughness *= s;
    d.metallic *= s;
    d.specular *= s;
    d.normalX *= s;
    d.normalY *= s;
    d.normalZ *= s;
}


// Sum over the parameters of the absolute derivatives of each channel (a look-up's weights add up to 1); sign: only of this sign.
vec3 slotDerivativeNorm(SlotDerivatives d, int sign) {
    if (sign == 0)
        return abs(d.baseColor) + abs(d.roughness) + abs(d.metallic) + abs(d.specular) + abs(d.normalX) + abs(d.normalY) + abs(d.normalZ);
    const float s = float(sign);
    const vec3 zero = vec3(0);
    return max(s * d.baseColor, zero) + max(s * d.roughness, zero) + max(s * d.metallic, zero) + max(s * d.specular, zero) +
           max(s * d.normalX, zero) + max(s * d.normalY, zero) + max(s * d.normalZ, zero);
}

bool anySlotDerivative(SlotDerivatives d) { return any(greaterThan(slotDerivativeNorm(d, 0), vec3(0))); }

// f |cos| and its derivatives; slots of this material nobody asked for stay zero. `single`: of a single direction, drawn with `drawnBy` as the normal.
vec3 scatterDerivatives(SurfacePoint p, SurfaceMaterial m, vec3 drawnBy, vec3 wo, vec3 wi, bool single, OUT(SlotDerivatives) d) {
    BsdfDerivatives b;
    vec3 f;
    if (kSmoothLobes && single)
        f = singleCosDerivatives(m.surface, drawnBy, wo, wi, b);
    else
        f = bsdfCosDerivatives(m.surface, m.normal, wo, wi, b);
    const uint asked = m.flags >> kDifferentiatedShift;
    d = noSlotDerivatives();
    if (kDiffBaseColor && (asked & (1u << kSlotBaseColor)) != 0) d.baseColor = b.baseColor * m.colorFactor;
    if (kDiffRoughness && (asked & (1u << kSlotRoughness)) != 0) d.roughness = b.roughness;
    if (kDiffMetallic && (asked & (1u << kSlotMetallic)) != 0) d.metallic = b.metallic;
    if (kDiffSpecular && (asked & (1u << kSlotSpecular)) != 0) d.specular = b.specular;
    if (kDiffNormal && (asked & (1u << kSlotNormal)) != 0) {
        // n = frame t / |t|: df/dt = (1 - t t^T / |t|^2) frame^T df/dn / |t|.
        const vec3 raw = textureValue(p.material, kSlotNormal, p.uv0, p.uv1, kFrozen ? scene.frozenTexels : 0);
        // Shorter vectors are replaced by the surface's own normal, which does not depend on them (surfaceMaterial).
        const float length2 = dot(raw, raw);
        const float inverseLength = length2 > 1e-20 ? inversesqrt(length2) : 0.0;
        const vec3 t = raw * inverseLength;
        const bool second = kTexcoord1 && (slotTexel((p.material * kSlotsPerMaterial + kSlotNormal) * kSlotTexels).w & kSlotTexcoord1) != 0;
        const mat3 frame = tangentFrame(p, second);
        const vec3 x = frame[0].x * b.normalX + frame[0].y * b.normalY + frame[0].z * b.normalZ;
        const vec3 y = frame[1].x * b.normalX + frame[1].y * b.normalY + frame[1].z * b.normalZ;
        const vec3 z = frame[2].x * b.normalX + frame[2].y * b.normalY + frame[2].z * b.normalZ;
        const vec3 radial = t.x * x + t.y * y + t.z * z;
        d.normalX = (x - t.x * radial) * inverseLength;
        d.normalY = (y - t.y * radial) * inverseLength;
        d.normalZ = (z - t.z * radial) * inverseLength;
    }
    return f;
}

// The value alone.
vec3 scattered(SurfaceMaterial m, vec3 drawnBy, vec3 wo, vec3 wi, bool single) {
    BsdfDerivatives unused; // the compiler drops what computes them
    if (kSmoothLobes && single) return singleCosDerivatives(m.surface, drawnBy, wo, wi, unused);
    return bsdfCos(m.surface, m.normal, wo, wi);
}

// part 0: the drawn direction, dw_i; part 1: the light sample, dN_i before visibility.
void tapeSlotDerivatives(uint slot, uint part, SlotDerivatives d) {
    if (kDiffBaseColor) tapePut3(slot, kPlaneBaseColor + 3 * part, d.baseColor);
    if (kDiffRoughness) tapePut3(slot, kPlaneRoughness + 3 * part, d.roughness);
    if (kDiffMetallic) tapePut3(slot, kPlaneMetallic + 3 * part, d.metallic);
    if (kDiffSpecular) tapePut3(slot, kPlaneSpecular + 3 * part, d.specular);
    if (kDiffNormal) {
        tapePut3(slot, kPlaneNormal + 9 * part, d.normalX);
        tapePut3(slot, kPlaneNormal + 9 * part + 3, d.normalY);
        tapePut3(slot, kPlaneNormal + 9 * part + 6, d.normalZ);
    }
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

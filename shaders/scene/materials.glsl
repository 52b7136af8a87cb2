// Material slots: where a surface point reads a slot, and what stands there.
// Expects kBindMaterials, kBindSlots, kBindValues (and kBindPacked) as materialTexel(), slotTexel(), valueTexel(), packedTexel().

struct SlotAddress {
    uint offset, flags, gradient;
    TexelWeights texels;
};

// The texels slot `kind` of `material` is read from at the texture coordinates.
SlotAddress slotAddress(uint material, uint kind, vec2 uv0, vec2 uv1) {
    const uint at = (material * kSlotsPerMaterial + kind) * kSlotTexels;
    const uvec4 head = slotTexel(at);
    const uvec4 tail = slotTexel(at + 2);
    SlotAddress a;
    a.offset = head.x;
    a.flags = head.w;
    a.gradient = tail.z;
    a.texels = TexelWeights(uvec4(0), vec4(1, 0, 0, 0));
    if (kTextures && head.y * head.z > 1) {
        const vec4 m = uintBitsToFloat(slotTexel(at + 1));
        const vec2 uv = kTexcoord1 && (head.w & kSlotTexcoord1) != 0 ? uv1 : uv0;
        const vec2 moved = vec2(m.x * uv.x + m.z * uv.y, m.y * uv.x + m.w * uv.y) + uintBitsToFloat(tail.xy);
        a.texels = texelWeights(moved, head.y, head.z, head.w & kSlotWrapUMask, (head.w >> kSlotWrapVShift) & 3u, (head.w & kSlotNearest) != 0);
    }
    return a;
}

float srgbToLinear(float e) { return e <= 0.04045 ? e / 12.92 : pow((e + 0.055) / 1.055, 2.4); }

vec3 packedValue(uint at, SlotAddress a, uint texel) {
    vec3 c = unpackUnorm4x8(packedTexel(a.offset + texel)).xyz;
    if ((a.flags & kSlotSrgb) != 0) c = vec3(srgbToLinear(c.x), srgbToLinear(c.y), srgbToLinear(c.z));
    return uintBitsToFloat(slotTexel(at + 3)).xyz * c + uintBitsToFloat(slotTexel(at + 4)).xyz;
}

float scalarValue(uint offset, uint index) { return valueTexel(offset + (index >> 2))[index & 3u]; }

// Interpolated value; scalar slots fill all three channels. `frozen`: offset of the parameter values used.
vec3 slotValue(SlotAddress a, uint material, uint kind, uint frozen) {
    const uvec4 i = a.texels.index;
    const vec4 w = a.texels.weight;
    if (kPackedTextures && (a.flags & kSlotPacked) != 0) {
        const uint at = (material * kSlotsPerMaterial + kind) * kSlotTexels;
        return w.x * packedValue(at, a, i.x) + w.y * packedValue(at, a, i.y) + w.z * packedValue(at, a, i.z) + w.w * packedValue(at, a, i.w);
    }
    const uint o = a.offset + frozen;
    if ((a.flags & kSlotScalar) != 0)
        return vec3(w.x * scalarValue(o, i.x) + w.y * scalarValue(o, i.y) + w.z * scalarValue(o, i.z) + w.w * scalarValue(o, i.w));
    return w.x * valueTexel(o + i.x).xyz + w.y * valueTexel(o + i.y).xyz + w.z * valueTexel(o + i.z).xyz + w.w * valueTexel(o + i.w).xyz;
}

vec3 textureValue(uint material, uint kind, vec2 uv0, vec2 uv1, uint frozen) {
    return slotValue(slotAddress(material, kind, uv0, uv1), material, kind, frozen);
}

// What a surface is made of at a point.
struct SurfaceMaterial {
    Surface surface;
    vec3 normal; // shading normal after normal mapping, unit
    vec3 colorFactor; // vertex colour that multiplied baseColor
    uint flags;
};

// The unit tangent-space normal is t/|t|; world normal = frame * t/|t|.
SurfaceMaterial surfaceMaterial(SurfacePoint p, uint frozenMaterials, uint frozenTexels) {
    const uint at = (p.material + frozenMaterials) * kMaterialTexels;
    const uvec4 m0 = materialTexel(at), m1 = materialTexel(at + 1);
    SurfaceMaterial m;
    m.flags = m1.w;
    m.surface.baseColor = uintBitsToFloat(m0.xyz);
    m.surface.roughness = uintBitsToFloat(m0.w);
    m.surface.metallic = uintBitsToFloat(m1.x);
    m.surface.specular = uintBitsToFloat(m1.y);
    m.surface.ior = uintBitsToFloat(m1.z);
    m.surface.specularColor = vec3(1);
    if (kLobeSpecular) m.surface.specularColor = uintBitsToFloat(materialTexel(at + 2).xyz);
    m.normal = p.normal;
    m.colorFactor = vec3(1);
    if (kTextures && (m.flags & 0xffu) != 0) {
        const uint f = m.flags;
        if ((f & (1u << kSlotBaseColor)) != 0) m.surface.baseColor = textureValue(p.material, kSlotBaseColor, p.uv0, p.uv1, frozenTexels);
        if (kLobeSpecular) {
            if ((f & (1u << kSlotRoughness)) != 0)
                m.surface.roughness = textureValue(p.material, kSlotRoughness, p.uv0, p.uv1, frozenTexels).x;
            if ((f & (1u << kSlotMetallic)) != 0) m.surface.metallic = textureValue(p.material, kSlotMetallic, p.uv0, p.uv1, frozenTexels).x;
            if ((f & (1u << kSlotSpecular)) != 0) m.surface.specular = textureValue(p.material, kSlotSpecular, p.uv0, p.uv1, frozenTexels).x;
        }
        if (kNormalMaps && (f & (1u << kSlotNormal)) != 0) {
            const vec3 t = textureValue(p.material, kSlotNormal, p.uv0, p.uv1, frozenTexels);
            const float length2 = dot(t, t);
            const bool second = kTexcoord1 && (slotTexel((p.material * kSlotsPerMaterial + kSlotNormal) * kSlotTexels).w & kSlotTexcoord1) != 0;
            if (length2 > 1e-20) m.normal = normalize(tangentFrame(p, second) * (t * inversesqrt(length2)));
        }
    }
    if (kColors) {
        m.colorFactor = p.color.xyz;
        m.surface.baseColor *= m.colorFactor;
    }
    return m;
}

// Radiance leaving the front face of an emissive material.
vec3 emittedRadiance(uint material, uint flags, vec2 uv0, vec2 uv1, uint frozenMaterials, uint frozenTexels) {
    if (kTextures && (flags & (1u << kSlotEmission)) != 0) return textureValue(material, kSlotEmission, uv0, uv1, frozenTexels);
    return uintBitsToFloat(materialTexel((material + frozenMaterials) * kMaterialTexels + 3).xyz);
}

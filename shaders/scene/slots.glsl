// Material slots: the texels a slot is read from at texture coordinates, and what stands there.
// Expects kBindMaterials, kBindSlots, kBindValues (and kBindPacked) as materialTexel(), slotTexel(), valueTexel(), packedTexel().

struct SlotAddress {
    uint offset, flags, gradient;
    TexelWeights texels;
};

uint wrapAs(uint bits) { return kWrap == kWrapsDiffer ? bits : kWrap; }
bool isNearest(uint flags) { return kFilter == kFiltersDiffer ? (flags & kSlotNearest) != 0 : kFilter == kFilterNearest; }

// The texels that the slot at `place` of the table is read from at the texture coordinates.
SlotAddress slotAddressAt(uint place, vec2 uv0, vec2 uv1) {
    const uint at = place * kSlotTexels;
    const uvec4 head = slotTexel(at);
    const uvec4 tail = slotTexel(at + 2);
    SlotAddress a;
    a.offset = head.x;
    a.flags = head.w;
    a.gradient = tail.z;
    a.texels = TexelWeights(uvec4(0), vec4(1, 0, 0, 0));
    if (kTextures && head.y * head.z > 1) {
        vec2 uv = kTexcoord1 && (head.w & kSlotTexcoord1) != 0 ? uv1 : uv0;
        if (kTextureTransforms) {
            const vec4 m = uintBitsToFloat(slotTexel(at + 1));
            uv = vec2(m.x * uv.x + m.z * uv.y, m.y * uv.x + m.w * uv.y) + uintBitsToFloat(tail.xy);
        }
        a.texels = texelWeights(uv, head.y, head.z, wrapAs(head.w & kSlotWrapUMask), wrapAs((head.w >> kSlotWrapVShift) & 3u), isNearest(head.w));
    }
    return a;
}

SlotAddress slotAddress(uint material, uint kind, vec2 uv0, vec2 uv1) { return slotAddressAt(material * kSlotsPerMaterial + kind, uv0, uv1); }

float srgbToLinear(float e) { return e <= 0.04045 ? e / 12.92 : pow((e + 0.055) / 1.055, 2.4); }

vec3 packedValue(uint at, SlotAddress a, uint texel) {
    vec3 c = unpackUnorm4x8(packedTexel(a.offset + texel)).xyz;
    if ((a.flags & kSlotSrgb) != 0) c = vec3(srgbToLinear(c.x), srgbToLinear(c.y), srgbToLinear(c.z));
    return uintBitsToFloat(slotTexel(at + 3)).xyz * c + uintBitsToFloat(slotTexel(at + 4)).xyz;
}

// Alpha of the texture whose slot is at `place`: 8 bits, linear.
float alphaValue(uint place, vec2 uv0, vec2 uv1) {
    const SlotAddress a = slotAddressAt(place, uv0, uv1);
    float alpha = 0.0;
    for (uint k = 0; k < 4; ++k) alpha += a.texels.weight[k] * unpackUnorm4x8(packedTexel(a.offset + a.texels.index[k])).x;
    return alpha;
}

float scalarValue(uint offset, uint index) { return valueTexel(offset + (index >> 2))[index & 3u]; }

// Interpolated value; scalar slots fill all three channels. `kind` is a constant, so that ways to read that its textures do not have fold away.
// firstTexel: where the set of values begins that is read.
vec3 slotValue(SlotAddress a, uint material, uint kind, uint firstTexel) {
    const uvec4 i = a.texels.index;
    const vec4 w = a.texels.weight;
    const uint slot = 1u << kind;
    if ((kPackedSlots & slot) != 0 && (a.flags & kSlotPacked) != 0) {
        const uint at = (material * kSlotsPerMaterial + kind) * kSlotTexels;
        return w.x * packedValue(at, a, i.x) + w.y * packedValue(at, a, i.y) + w.z * packedValue(at, a, i.z) + w.w * packedValue(at, a, i.w);
    }
    const uint o = a.offset + firstTexel;
    if ((kColorSlots & slot) == 0 || ((kScalarSlots & slot) != 0 && (a.flags & kSlotScalar) != 0))
        return vec3(w.x * scalarValue(o, i.x) + w.y * scalarValue(o, i.y) + w.z * scalarValue(o, i.z) + w.w * scalarValue(o, i.w));
    return w.x * valueTexel(o + i.x).xyz + w.y * valueTexel(o + i.y).xyz + w.z * valueTexel(o + i.z).xyz + w.w * valueTexel(o + i.w).xyz;
}

vec3 textureValue(uint material, uint kind, vec2 uv0, vec2 uv1, uint firstTexel) {
    return slotValue(slotAddress(material, kind, uv0, uv1), material, kind, firstTexel);
}

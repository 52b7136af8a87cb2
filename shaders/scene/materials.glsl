// What a surface is made of at a point, and what it emits. Expects slots.glsl, geometry.glsl and what they expect.
#include "scene/asked_slots.glsl"
#include "scene/blend.glsl"

// What a surface is made of at a point.
struct SurfaceMaterial {
    Surface surface;
    vec3 normal; // shading normal after normal mapping, unit
    vec3 colorFactor; // vertex colour that multiplied baseColor
    uint flags;
    float share; // what scatters is this much: of a blend, the weight of what was chosen over its probability; else 1
};

// The direction in which anisotropic microfacets are rougher (or less rough, of a model that has two alphas), in the plane of the surface's own normal.
vec3 anisotropyDirection(SurfacePoint p) {
    const uint at = (p.material * kSlotsPerMaterial + kSlotAnisotropy) * kSlotTexels;
    const mat3 frame = tangentFrame(p, (slotTexel(at).w & kSlotTangents1) != 0);
    const uint place = slotTexel(at + 2).w;
    if (place == kNone) return frame[0];
    const SlotAddress a = slotAddressAt(place, p.uv0, p.uv1);
    vec2 d = vec2(0);
    for (uint k = 0; k < 4; ++k) d += a.texels.weight[k] * unpackSnorm2x16(packedTexel(a.offset + a.texels.index[k]));
    const float length2 = dot(d, d);
    return length2 > 1e-8 ? frame * vec3(d * inversesqrt(length2), 0.0) : frame[0];
}

// Of a clear coat with normals of its own, unit; zero: it has those of what is below. Seen from wo.
vec3 clearCoatNormal(SurfacePoint p, vec3 wo) {
    const uint place = slotTexel((p.material * kSlotsPerMaterial + kSlotClearcoat) * kSlotTexels + 2).w;
    if (place == kNone) return vec3(0);
    const SlotAddress a = slotAddressAt(place, p.uv0, p.uv1);
    vec2 n = vec2(0);
    for (uint k = 0; k < 4; ++k) n += a.texels.weight[k] * unpackSnorm2x16(packedTexel(a.offset + a.texels.index[k]));
    const mat3 frame = tangentFrame(p, kTexcoord1 && (a.flags & kSlotTexcoord1) != 0);
    return visibleNormal(p.normal, normalize(frame * vec3(n, sqrt(max(1.0 - dot(n, n), 0.0)))), wo);
}

// The unit vector t / |t| of the normal map, t being its texels' mean, in world space; shorter vectors are replaced by the surface's own normal, which does
// not depend on them. inverseLength: 1 / |t|, or 0 there.
vec3 mappedNormal(SurfacePoint p, uint firstTexel, OUT(mat3) frame, OUT(vec3) t, OUT(float) inverseLength) {
    const vec3 raw = textureValue(p.material, kSlotNormal, p.uv0, p.uv1, firstTexel);
    const float length2 = dot(raw, raw);
    inverseLength = length2 > 1e-20 ? inversesqrt(length2) : 0.0;
    t = raw * inverseLength;
    const bool second = kTexcoord1 && (slotTexel((p.material * kSlotsPerMaterial + kSlotNormal) * kSlotTexels).w & kSlotTexcoord1) != 0;
    frame = tangentFrame(p, second);
    return inverseLength > 0.0 ? normalize(frame * t) : p.normal;
}

// Reads what the slots of a mask (1 << kSlotBaseColor ...) hold. Seen from wo, which only mapped normals depend on. There may be two sets of materials and
// values: firstMaterial and firstTexel are where the one that is meant begins, 0 for the first set.
void readSlots(INOUT(SurfaceMaterial) m, SurfacePoint p, vec3 wo, uint slots, uint firstMaterial, uint firstTexel) {
#define READS(Slot) ((slots & (1u << kSlot##Slot)) != 0)
#define TEXTURED(Slot) (kTextured##Slot && (m.flags & slots & (1u << kSlot##Slot)) != 0)
#define TEXTURE_VALUE(Slot) textureValue(p.material, kSlot##Slot, p.uv0, p.uv1, firstTexel)
    const uint at = (p.material + firstMaterial) * kMaterialTexels;
    const uvec4 m0 = materialTexel(at), m1 = materialTexel(at + 1);
    if (READS(BaseColor)) m.surface.baseColor = uintBitsToFloat(m0.xyz);
    if (READS(Roughness)) m.surface.roughness = uintBitsToFloat(m0.w);
    if (READS(Metallic)) m.surface.metallic = uintBitsToFloat(m1.x);
    if (READS(Specular)) {
        m.surface.specular = uintBitsToFloat(m1.y);
        if (kLobeSpecular || kOtherModels) m.surface.specularColor = uintBitsToFloat(materialTexel(at + 2).xyz);
    }
    if (kBlend && READS(Weight)) m.share = blendShare(p, firstTexel);
    if (kTextures && (m.flags & ((1u << kFlaggedSlots) - 1u)) != 0) {
        if (TEXTURED(BaseColor)) m.surface.baseColor = TEXTURE_VALUE(BaseColor);
        if (kLobeSpecular && IS_METALLIC_ROUGHNESS(m.surface)) {
            if (TEXTURED(Roughness)) m.surface.roughness = TEXTURE_VALUE(Roughness).x;
            if (TEXTURED(Metallic)) m.surface.metallic = TEXTURE_VALUE(Metallic).x;
            if (TEXTURED(Specular)) m.surface.specular = TEXTURE_VALUE(Specular).x;
        }
        if (kOtherModels && !IS_METALLIC_ROUGHNESS(m.surface)) {
            if (TEXTURED(Roughness)) m.surface.roughness = TEXTURE_VALUE(Roughness).x;
            if (TEXTURED(Specular) && !IS_CONDUCTOR(m.surface)) m.surface.specularColor = TEXTURE_VALUE(Specular);
        }
#define LOBE_SLOT(number, Name, name, channels, highest, adam, sgd, extension, factor, standard, texture, channel) \
        if (kTextured##Name && (m.flags & slots & (1u << number) & ((1u << kFlaggedSlots) - 1u)) != 0) m.surface.lobe[number - kCommonSlots] = TEXTURE_VALUE(Name).x;
#include "shared/slots.def"
        if (TEXTURED(Normal)) {
            mat3 frame;
            vec3 t;
            float inverseLength;
            m.normal = visibleNormal(p.normal, mappedNormal(p, firstTexel, frame, t, inverseLength), wo);
        }
    }
    if (IS_ANISOTROPIC(m.surface) && READS(Anisotropy)) m.surface.lobe[kSlotAnisotropy - kCommonSlots] = TEXTURE_VALUE(Anisotropy).x;
    if (HAS_SHEEN(m.surface)) {
        if (READS(SheenRoughness)) m.surface.lobe[kSlotSheenRoughness - kCommonSlots] = TEXTURE_VALUE(SheenRoughness).x;
        if (READS(SheenColor)) m.surface.sheenColor = TEXTURE_VALUE(SheenColor);
    }
    if (kColors && READS(BaseColor)) m.surface.baseColor *= m.colorFactor;
#undef READS
#undef TEXTURED
#undef TEXTURE_VALUE
}

// With a set of values, see readSlots().
SurfaceMaterial surfaceMaterial(SurfacePoint p, vec3 wo, uint firstMaterial, uint firstTexel) {
    SurfaceMaterial m;
    const uvec4 m1 = materialTexel((p.material + firstMaterial) * kMaterialTexels + 1);
    m.flags = m1.w;
    m.surface.ior = uintBitsToFloat(m1.z);
    m.surface.asked = askedSlots(p.material, m.flags);
    m.surface.model = m.flags;
    m.surface.specularColor = vec3(1);
    m.normal = p.normal;
    m.colorFactor = kColors ? p.color.xyz : vec3(1);
    readSlots(m, p, wo, ~0u, firstMaterial, firstTexel);
    if (IS_ANISOTROPIC(m.surface)) m.surface.tangent = anisotropyDirection(p);
    if (kCoatNormals && HAS_CLEAR_COAT(m.surface)) m.surface.coatNormal = clearCoatNormal(p, wo);
    return m;
}

// Radiance leaving the front face of an emissive material.
vec3 emittedRadiance(uint material, uint flags, vec2 uv0, vec2 uv1, uint firstMaterial, uint firstTexel) {
    if (kTexturedEmission && (flags & (1u << kSlotEmission)) != 0) return textureValue(material, kSlotEmission, uv0, uv1, firstTexel);
    return uintBitsToFloat(materialTexel((material + firstMaterial) * kMaterialTexels + 3).xyz);
}

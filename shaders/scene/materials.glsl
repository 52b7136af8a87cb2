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

// Seen from wo, which only mapped normals depend on. There may be two sets of materials and values: firstMaterial and firstTexel are where
// the one that is meant begins, 0 for the first set.
SurfaceMaterial surfaceMaterial(SurfacePoint p, vec3 wo, uint firstMaterial, uint firstTexel) {
    const uint at = (p.material + firstMaterial) * kMaterialTexels;
    const uvec4 m0 = materialTexel(at), m1 = materialTexel(at + 1);
    SurfaceMaterial m;
    m.flags = m1.w;
    m.surface.baseColor = uintBitsToFloat(m0.xyz);
    m.surface.roughness = uintBitsToFloat(m0.w);
    m.surface.metallic = uintBitsToFloat(m1.x);
    m.surface.specular = uintBitsToFloat(m1.y);
    m.surface.ior = uintBitsToFloat(m1.z);
    m.surface.asked = askedSlots(p.material, m.flags);
    m.surface.model = m.flags;
    m.surface.specularColor = vec3(1);
    if (kLobeSpecular || kOtherModels) m.surface.specularColor = uintBitsToFloat(materialTexel(at + 2).xyz);
    m.normal = p.normal;
    m.colorFactor = vec3(1);
    if (kBlend) m.share = blendShare(p, firstTexel);
    if (kTextures && (m.flags & ((1u << kFlaggedSlots) - 1u)) != 0) {
        const uint f = m.flags;
        if (kTexturedBaseColor && (f & (1u << kSlotBaseColor)) != 0) m.surface.baseColor = textureValue(p.material, kSlotBaseColor, p.uv0, p.uv1, firstTexel);
        if (kLobeSpecular && IS_METALLIC_ROUGHNESS(m.surface)) {
            if (kTexturedRoughness && (f & (1u << kSlotRoughness)) != 0)
                m.surface.roughness = textureValue(p.material, kSlotRoughness, p.uv0, p.uv1, firstTexel).x;
            if (kTexturedMetallic && (f & (1u << kSlotMetallic)) != 0) m.surface.metallic = textureValue(p.material, kSlotMetallic, p.uv0, p.uv1, firstTexel).x;
            if (kTexturedSpecular && (f & (1u << kSlotSpecular)) != 0) m.surface.specular = textureValue(p.material, kSlotSpecular, p.uv0, p.uv1, firstTexel).x;
        }
        if (kOtherModels && !IS_METALLIC_ROUGHNESS(m.surface)) {
            if (kTexturedRoughness && (f & (1u << kSlotRoughness)) != 0)
                m.surface.roughness = textureValue(p.material, kSlotRoughness, p.uv0, p.uv1, firstTexel).x;
            if (kTexturedSpecular && !IS_CONDUCTOR(m.surface) && (f & (1u << kSlotSpecular)) != 0)
                m.surface.specularColor = textureValue(p.material, kSlotSpecular, p.uv0, p.uv1, firstTexel);
        }
#define LOBE_SLOT(number, Name, name, channels, highest, adam, sgd, extension, factor, standard, texture, channel) \
    if (kTextured##Name && (f & (1u << number) & ((1u << kFlaggedSlots) - 1u)) != 0) m.surface.lobe[number - kCommonSlots] = textureValue(p.material, number, p.uv0, p.uv1, firstTexel).x;
#include "shared/slots.def"
        if (kTexturedNormal && (f & (1u << kSlotNormal)) != 0) {
            mat3 frame;
            vec3 t;
            float inverseLength;
            m.normal = visibleNormal(p.normal, mappedNormal(p, firstTexel, frame, t, inverseLength), wo);
        }
    }
    if (IS_ANISOTROPIC(m.surface)) {
        m.surface.lobe[kSlotAnisotropy - kCommonSlots] = textureValue(p.material, kSlotAnisotropy, p.uv0, p.uv1, firstTexel).x;
        m.surface.tangent = anisotropyDirection(p);
    }
    if (HAS_SHEEN(m.surface)) {
        m.surface.lobe[kSlotSheenRoughness - kCommonSlots] = textureValue(p.material, kSlotSheenRoughness, p.uv0, p.uv1, firstTexel).x;
        m.surface.sheenColor = textureValue(p.material, kSlotSheenColor, p.uv0, p.uv1, firstTexel);
    }
    if (kCoatNormals && HAS_CLEAR_COAT(m.surface)) m.surface.coatNormal = clearCoatNormal(p, wo);
    if (kColors) {
        m.colorFactor = p.color.xyz;
        m.surface.baseColor *= m.colorFactor;
    }
    return m;
}

// Radiance leaving the front face of an emissive material.
vec3 emittedRadiance(uint material, uint flags, vec2 uv0, vec2 uv1, uint firstMaterial, uint firstTexel) {
    if (kTexturedEmission && (flags & (1u << kSlotEmission)) != 0) return textureValue(material, kSlotEmission, uv0, uv1, firstTexel);
    return uintBitsToFloat(materialTexel((material + firstMaterial) * kMaterialTexels + 3).xyz);
}

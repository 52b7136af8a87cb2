// Blends of two materials: every vertex is of the one or the other, by chance, and what it scatters weighs weight over probability. So both keep their
// slots, lobes and single directions to themselves, and of the tape's records each is of one material. Expects slots.glsl and geometry.glsl.

// Share of the second material at the point; of either material.
float blendWeight(SurfacePoint p, uint firstTexel) {
    return textureValue(p.material, kSlotWeight, p.uv0, p.uv1, firstTexel).x;
}

// The second material of a blend.
uint blendSecond(uint material) { return slotTexel((material * kSlotsPerMaterial + kSlotWeight) * kSlotTexels + 2).w; }

// The material whose interior lies behind the surface: where what scatters is met, that of the glass it is blended with.
uint interiorMaterial(SurfacePoint p) { return p.blend < 0.0 ? blendSecond(p.material) : p.material; }

// Weight over probability of what was chosen; 1 where there is no blend.
float blendShare(SurfacePoint p, uint firstTexel) {
    if (p.blend == 0.0) return 1.0;
    const float weight = blendWeight(p, firstTexel);
    return p.blend > 0.0 ? weight * p.blend : (weight - 1.0) * p.blend;
}

// Makes of a blend what is met, u in [0,1). Neither material is starved where the weight's derivative is asked for, which compares them; the same in images,
// whose second set of values may have another weight.
void chooseBlended(INOUT(SurfacePoint) p, float u) {
    const uint flags = materialTexel(p.material * kMaterialTexels + 1).w;
    if ((flags & kMaterialBlend) == 0) return;
    float probability = blendWeight(p, 0);
    if ((flags & kMaterialWeightDifferentiated) != 0) probability = clamp(probability, 0.1, 0.9);
    const bool second = u < probability;
    p.blend = second ? 1.0 / probability : -1.0 / (1.0 - probability);
    if (second) p.material = blendSecond(p.material);
}

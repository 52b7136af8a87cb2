// Where a ray finds a hole in a material with alpha: below the cutoff of glTF's alphaMode MASK; by chance, with probability 1 - alpha, of BLEND.
// Expects triangleIndices(), attributeTexel(), kAttributeTexels, kColors, kCoverage, lib/random.glsl and what slots.glsl expects.

// In (0, 1], by the bits of the ray: every ray of a path draws anew, whoever traces it, and a triangle that it meets twice gives the same answer.
float coverageThreshold(uint triangle, vec3 origin, vec3 direction) {
    const uvec4 h = hash4(uvec4(floatBitsToUint(direction), triangle));
    return float((hash4(h + uvec4(floatBitsToUint(origin), 0x636f7665u)).x >> 8) + 1u) * (1.0 / 16777216.0);
}

bool isCutOut(uint triangle, vec2 barycentrics, vec3 origin, vec3 direction) {
    const uvec4 indices = triangleIndices(triangle);
    const uint material = indices.w * kMaterialTexels;
    const uint flags = materialTexel(material + 1).w;
    if ((flags & kMaterialAlphaMask) == 0) return false;
    float cutoff = uintBitsToFloat(materialTexel(material + 2).w);
    if (kCoverage && (flags & kMaterialCoverage) != 0) cutoff *= coverageThreshold(triangle, origin, direction);
    const uint slot = materialTexel(material + 3).w;
    const uvec3 at = indices.xyz * kAttributeTexels;
    const vec3 b = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
    float alpha = 1.0;
    if (slot != kNone) {
        const vec4 s0 = attributeTexel(at.x + 1), s1 = attributeTexel(at.y + 1), s2 = attributeTexel(at.z + 1);
        const vec3 u = vec3(attributeTexel(at.x).w, attributeTexel(at.y).w, attributeTexel(at.z).w);
        const vec2 uv0 = vec2(dot(b, u), dot(b, vec3(s0.x, s1.x, s2.x)));
        vec2 uv1 = vec2(0);
        if (kTexcoord1) uv1 = b.x * s0.yz + b.y * s1.yz + b.z * s2.yz;
        alpha = alphaValue(slot, uv0, uv1);
    }
    if (kColors) {
        const uvec3 color = at + (kAttributeTexels - 1);
        const float a = attributeTexel(color.x).w;
        alpha *= a + b.y * (attributeTexel(color.y).w - a) + b.z * (attributeTexel(color.z).w - a);
    }
    return alpha < cutoff;
}

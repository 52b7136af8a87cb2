// From a hit to the surface point: position, normals, texture coordinates.
// Expects kBindTriangles, kBindIndices and kBindAttributes to be declared as triangleTexel(), triangleIndices(), attributeTexel().

struct SurfacePoint {
    vec3 position;
    vec3 faceNormal; // unit, towards the counter-clockwise side
    vec3 normal; // shading normal before normal mapping, unit
    vec2 uv0, uv1;
    vec4 color;
    vec4 tangent; // as in the file; xyz zero: not given
    uint triangle, material;
    float blend; // of a blend: over its probability, what was chosen to be met here: positive the second material, negative the first; else 0
    float magnitude; // largest absolute coordinate of the triangle: the scale of rounding errors
};

SurfacePoint surfacePoint(uint triangle, vec2 barycentrics) {
    const vec4 t0 = triangleTexel(3 * triangle), t1 = triangleTexel(3 * triangle + 1), t2 = triangleTexel(3 * triangle + 2);
    const vec3 v0 = t0.xyz, e1 = t1.xyz, e2 = t2.xyz;
    const float b1 = barycentrics.x, b2 = barycentrics.y, b0 = 1.0 - b1 - b2;
    SurfacePoint p;
    p.triangle = triangle;
    p.position = v0 + b1 * e1 + b2 * e2;
    p.magnitude = max(largestCoordinate(v0), max(largestCoordinate(v0 + e1), largestCoordinate(v0 + e2)));
    p.faceNormal = vec3(t0.w, t1.w, t2.w);
    p.normal = p.faceNormal;
    p.uv0 = vec2(0);
    p.uv1 = vec2(0);
    p.color = vec4(1);
    p.tangent = vec4(0);
    if (kBlend) p.blend = 0.0;
    const uvec4 indices = triangleIndices(triangle);
    p.material = indices.w;
    if (kVertexNormals || kTextures) {
        const uvec3 at = indices.xyz * kAttributeTexels;
        // Texture coordinates of a surface without textures are not read anywhere.
        const bool textured = kTextures && (materialTexel(p.material * kMaterialTexels + 1).w & (((1u << kFlaggedSlots) - 1u) | kMaterialBlend | (kTexturedAnisotropy ? kMaterialAnisotropic : 0u) | (kTexturedSheenColor ? kMaterialSheen : 0u))) != 0;
        vec4 a0 = vec4(0), a1 = vec4(0), a2 = vec4(0);
        if (kVertexNormals || textured) {
            a0 = attributeTexel(at.x);
            a1 = attributeTexel(at.y);
            a2 = attributeTexel(at.z);
        }
        if (kVertexNormals) {
            const vec3 n = b0 * a0.xyz + b1 * a1.xyz + b2 * a2.xyz;
            const float length2 = dot(n, n);
            if (length2 > 1e-20) p.normal = n * inversesqrt(length2);
        }
        if (textured) {
            const vec4 s0 = attributeTexel(at.x + 1), s1 = attributeTexel(at.y + 1), s2 = attributeTexel(at.z + 1);
            p.uv0 = vec2(b0 * a0.w + b1 * a1.w + b2 * a2.w, b0 * s0.x + b1 * s1.x + b2 * s2.x);
            if (kTexcoord1) p.uv1 = b0 * s0.yz + b1 * s1.yz + b2 * s2.yz;
        }
        if (kTangents) p.tangent = b0 * attributeTexel(at.x + 2) + b1 * attributeTexel(at.y + 2) + b2 * attributeTexel(at.z + 2);
    }
    if (kColors) {
        const uvec3 at = indices.xyz * kAttributeTexels + (kAttributeTexels - 1);
        // By differences: equal colours stay what they are.
        const vec4 color = attributeTexel(at.x);
        p.color = color + b1 * (attributeTexel(at.y) - color) + b2 * (attributeTexel(at.z) - color);
    }
    return p;
}

// Derivatives of the texture coordinates' parametrisation: the tangent-space basis of a normal map, orthogonalised against the
// shading normal. Columns: tangent, bitangent, normal.
mat3 tangentFrame(SurfacePoint p, bool useTexcoord1) {
    vec3 t = p.tangent.xyz;
    float handedness = p.tangent.w < 0.0 ? -1.0 : 1.0;
    if (dot(t, t) < 1e-12) {
        const vec3 e1 = triangleTexel(3 * p.triangle + 1).xyz;
        const vec3 e2 = triangleTexel(3 * p.triangle + 2).xyz;
        const uvec3 at = triangleIndices(p.triangle).xyz * kAttributeTexels;
        vec2 c0, c1, c2;
        if (kTexcoord1 && useTexcoord1) {
            c0 = attributeTexel(at.x + 1).yz;
            c1 = attributeTexel(at.y + 1).yz;
            c2 = attributeTexel(at.z + 1).yz;
        } else {
            c0 = vec2(attributeTexel(at.x).w, attributeTexel(at.x + 1).x);
            c1 = vec2(attributeTexel(at.y).w, attributeTexel(at.y + 1).x);
            c2 = vec2(attributeTexel(at.z).w, attributeTexel(at.z + 1).x);
        }
        const vec2 d1 = c1 - c0, d2 = c2 - c0;
        const float area = d1.x * d2.y - d1.y * d2.x;
        // glTF's v runs down the image while tangent space has y up, hence the bitangent along decreasing v.
        const float orientation = area < 0.0 ? -1.0 : 1.0;
        t = (e1 * d2.y - e2 * d1.y) * orientation;
        t /= max(largestCoordinate(t), 1e-37); // edges and coordinates of any scale
        handedness = -orientation;
    }
    t -= p.normal * dot(p.normal, t);
    const float length2 = dot(t, t);
    if (length2 < 1e-12) {
        vec3 x, y;
        orthonormalFrame(p.normal, x, y);
        return mat3(x, y, p.normal);
    }
    t *= inversesqrt(length2);
    return mat3(t, cross(p.normal, t) * handedness, p.normal);
}

// What kernels leave for the next: rays, where they ended, what their paths have collected. Read in texels (lib/read_buffers.glsl).
// A kernel says which it reads, because it must not declare what it writes: CMPG_READ_RAYS, _HITS, _SHADOW_RAYS, _PREFIXES, _COPIES,
// _VERTICES, _PATHS, _ADJOINTS, _SORTED.
// Written in texels as well, by macros whose buffer is an array of uvec4: a store of 16 bytes costs CPU drivers less than those of its members.
#include "shared/bindings.h"
#include "shared/wavefront.h"
#include "lib/read_buffers.glsl"

#define TEXEL(xyz, w) uvec4(floatBitsToUint(xyz), w)
#define WRITE_RAY(rays, i, ray) { \
    rays[2 * (i)] = TEXEL((ray).origin, (ray).path); \
    rays[2 * (i) + 1] = TEXEL((ray).direction, floatBitsToUint((ray).pdf)); }
#define WRITE_HIT(hits, i, hit) hits[i] = uvec4(floatBitsToUint((hit).t), (hit).triangle, floatBitsToUint((hit).barycentrics));
#define WRITE_SHADOW_RAY(rays, i, ray) { \
    rays[2 * (i)] = TEXEL((ray).origin, floatBitsToUint((ray).distance)); \
    rays[2 * (i) + 1] = TEXEL((ray).direction, (ray).slot); }
#define WRITE_PREFIX(prefixes, i, prefix) { \
    prefixes[2 * (i)] = TEXEL((prefix).throughput, (prefix).branch); \
    prefixes[2 * (i) + 1] = TEXEL((prefix).tangent, (prefix).copies); }
#define WRITE_COPY(copies, i, copy) copies[i] = uvec4((copy).ray, (copy).index, floatBitsToUint((copy).weight), (copy).copies);
#define WRITE_VERTEX(vertices, i, v) { \
    vertices[3 * (i)] = TEXEL((v).emission, (v).child); \
    vertices[3 * (i) + 1] = TEXEL((v).direct, (v).shadow); \
    vertices[3 * (i) + 2] = TEXEL((v).weight, (v).path); }

#ifdef CMPG_READ_RAYS
QUEUE_UVEC4(rayTexel, kBindRays)
Ray readRay(uint i) {
    const uvec4 a = rayTexel(2 * i), b = rayTexel(2 * i + 1);
    return Ray(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), uintBitsToFloat(b.w));
}
uint pathOf(Ray ray) { return ray.path & ~kLightCounts; }
#endif

#ifdef CMPG_READ_HITS
QUEUE_UVEC4(hitTexel, kBindHits)
Hit readHit(uint i) {
    const uvec4 a = hitTexel(i);
    return Hit(uintBitsToFloat(a.x), a.y, uintBitsToFloat(a.zw));
}
#endif

#ifdef CMPG_READ_SHADOW_RAYS
QUEUE_UVEC4(shadowRayTexel, kBindShadowRays)
ShadowRay readShadowRay(uint i) {
    const uvec4 a = shadowRayTexel(2 * i), b = shadowRayTexel(2 * i + 1);
    return ShadowRay(uintBitsToFloat(a.xyz), uintBitsToFloat(a.w), uintBitsToFloat(b.xyz), b.w);
}
#endif

#ifdef CMPG_READ_PREFIXES
QUEUE_UVEC4(prefixTexel, kBindPrefixes)
Prefix readPrefix(uint i) {
    const uvec4 a = prefixTexel(2 * i), b = prefixTexel(2 * i + 1);
    return Prefix(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), b.w);
}
#endif

#ifdef CMPG_READ_VERTICES
QUEUE_UVEC4(vertexTexel, kBindVertices)
Vertex readVertex(uint i) {
    const uvec4 a = vertexTexel(3 * i), b = vertexTexel(3 * i + 1), c = vertexTexel(3 * i + 2);
    return Vertex(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), b.w, uintBitsToFloat(c.xyz), c.w);
}
#endif

#ifdef CMPG_READ_COPIES
QUEUE_UVEC4(copyTexel, kBindCopies)
Copy readCopy(uint i) {
    const uvec4 a = copyTexel(i);
    return Copy(a.x, a.y, uintBitsToFloat(a.z), a.w);
}
#endif

#ifdef CMPG_READ_SORTED
QUEUE_UINT(sortedVertex, kBindSorted)
#endif

#ifdef CMPG_READ_PATHS
QUEUE_UINT(pathWord, kBindPaths)
uvec2 readPath(uint i) { return uvec2(pathWord(2 * i), pathWord(2 * i + 1)); }
#endif

#ifdef CMPG_READ_ADJOINTS
QUEUE_UINT(adjointWord, kBindAdjoint)
vec3 readAdjoint(uint pixel) { return uintBitsToFloat(uvec3(adjointWord(3 * pixel), adjointWord(3 * pixel + 1), adjointWord(3 * pixel + 2))); }
#endif

// Structs that only some passes leave, from the words of the accessor given.
#define WORDS3(word, at) uvec3(word(at), word((at) + 1), word((at) + 2))
#define READ_ARRIVAL(word, i) Arrival(word(3 * (i)), word(3 * (i) + 1), uintBitsToFloat(word(3 * (i) + 2)))
#define READ_PARTS(word, i) DerivativeParts(uintBitsToFloat(WORDS3(word, 6 * (i))), uintBitsToFloat(WORDS3(word, 6 * (i) + 3)))
#define READ_MOMENT(word, i) VertexMoment(uintBitsToFloat(WORDS3(word, 5 * (i))), uintBitsToFloat(word(5 * (i) + 3)), word(5 * (i) + 4))

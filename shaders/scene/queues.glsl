// What kernels leave for the next: rays, where they ended, what their paths have collected. Read in texels (lib/read_buffers.glsl).
// A kernel says which it reads, because it must not declare what it writes: CMPG_READ_RAYS, _HITS, _SHADOW_RAYS, _PREFIXES, _COPIES,
// _VERTICES.
#include "shared/bindings.h"
#include "shared/wavefront.h"
#include "lib/read_buffers.glsl"

#ifdef CMPG_READ_RAYS
QUEUE_UVEC4(rayTexel, kBindRays)
Ray readRay(uint i) {
    const uvec4 a = rayTexel(2 * i), b = rayTexel(2 * i + 1);
    return Ray(uintBitsToFloat(a.xyz), a.w, uintBitsToFloat(b.xyz), uintBitsToFloat(b.w));
}
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

// The read-only tables of triangles' attributes and of materials, for kernels that look things up on surfaces.
#include "shared/bindings.h"
#include "lib/read_buffers.glsl"
READ_UVEC4(triangleIndices, kBindIndices)
READ_VEC4(attributeTexel, kBindAttributes)
READ_UVEC4(materialTexel, kBindMaterials)
READ_UVEC4(slotTexel, kBindSlots)
READ_VEC4(valueTexel, kBindValues)
READ_UINT(packedTexel, kBindPacked)
vec4 coatTexel(uint at) { return uintBitsToFloat(materialTexel(at)); } // lib/lobes/plastic.glsl

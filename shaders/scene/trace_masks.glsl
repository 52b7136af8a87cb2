// What the tracing kernels need to know of materials: where they are cut out. All of it folds away in scenes without alpha masks.
#include "shared/bindings.h"
#include "shared/features.h"
#include "shared/material.h"
#include "lib/read_buffers.glsl"
#include "lib/texel.glsl"

layout(constant_id = kTraceAlphaMask) const bool kAlphaMask = false;
layout(constant_id = kTraceAttributeTexels) const uint kAttributeTexels = 2u;
layout(constant_id = kTraceTexcoord1) const bool kTexcoord1 = false;
layout(constant_id = kTraceColors) const bool kColors = false;
const bool kTextures = true;
const bool kPackedTextures = true;

READ_UVEC4(triangleIndices, kBindIndices)
READ_VEC4(attributeTexel, kBindAttributes)
READ_UVEC4(materialTexel, kBindMaterials)
READ_UVEC4(slotTexel, kBindSlots)
READ_VEC4(valueTexel, kBindValues)
READ_UINT(packedTexel, kBindPacked)

#include "scene/slots.glsl"
#include "scene/alpha_mask.glsl"

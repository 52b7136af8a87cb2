// What the tracing kernels need to know of materials: where they are cut out. All of it folds away in scenes without alpha masks.
#include "shared/bindings.h"
#include "shared/features.h"
#include "shared/material.h"
#include "lib/texel.glsl"

layout(constant_id = kTraceAlphaMask) const bool kAlphaMask = false;
layout(constant_id = kTraceCoverage) const bool kCoverage = false;
layout(constant_id = kTraceAttributeTexels) const uint kAttributeTexels = 2u;
layout(constant_id = kTraceTexcoord1) const bool kTexcoord1 = false;
layout(constant_id = kTraceColors) const bool kColors = false;
const bool kTextures = true;
const uint kPackedSlots = 0u, kColorSlots = 0u, kScalarSlots = 0u; // no slot is read, alpha alone
const uint kWrap = kWrapsDiffer, kFilter = kFiltersDiffer;
const bool kTextureTransforms = true;

#include "scene/material_tables.glsl"

#include "lib/random.glsl"
#include "scene/slots.glsl"
#include "scene/alpha_mask.glsl"

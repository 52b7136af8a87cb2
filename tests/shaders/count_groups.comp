// Writes the group counts of an indirect dispatch.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "lib/dispatch.glsl"
layout(local_size_x = 1) in;
layout(binding = 0, scalar) writeonly buffer Output { uvec3 groups; } result;
layout(push_constant, scalar) uniform Push { uint items, size; } push;

void main() { result.groups = groupCounts(push.items, push.size); }

// Adds 1 to the element of every item, so that items left out and items visited twice both show.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "lib/dispatch.glsl"
layout(local_size_x = 64) in;
layout(binding = 0, scalar) buffer Output { uint at[]; } result;
layout(push_constant, scalar) uniform Push { uint count; } push;

void main() {
    const uint i = globalIndex();
    if (i >= push.count) return;
    result.at[i] += 1;
}

// Copies vec4s, uvec4s, floats and uints read through the accessors of read_buffers.glsl.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/dispatch.glsl"
#include "lib/read_buffers.glsl"
layout(local_size_x = 64) in;
READ_VEC4(vectors, 0)
READ_UVEC4(integers, 1)
READ_FLOAT(floats, 2)
READ_UINT(uints, 3)
layout(binding = 4, scalar) writeonly buffer Vectors { vec4 at[]; } vectorsOut;
layout(binding = 5, scalar) writeonly buffer Integers { uvec4 at[]; } integersOut;
layout(binding = 6, scalar) writeonly buffer Floats { float at[]; } floatsOut;
layout(binding = 7, scalar) writeonly buffer Uints { uint at[]; } uintsOut;
layout(push_constant, scalar) uniform Push { uint count; } push;

void main() {
    const uint i = globalIndex();
    if (i >= push.count) return;
    vectorsOut.at[i] = vectors(i);
    integersOut.at[i] = integers(i);
    floatsOut.at[i] = floats(i);
    uintsOut.at[i] = uints(i);
}

// Adds signed 64-bit numbers of all invocations to one: with the device's atomic, or with two 32-bit ones and a carry.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#ifndef CMPG_PORTABLE
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#include "lib/dispatch.glsl"
layout(local_size_x = 64) in;
layout(binding = 0, scalar) readonly buffer Input { uvec2 at[]; } numbers; // low, high word
#ifdef CMPG_PORTABLE
layout(binding = 1, scalar) buffer Sum { uint low, high; } sum;
#else
layout(binding = 1, scalar) buffer Sum { uint64_t value; } sum;
#endif
layout(push_constant, scalar) uniform Push { uint count; } push;

void main() {
    const uint i = globalIndex();
    if (i >= push.count) return;
    const uvec2 x = numbers.at[i];
#ifdef CMPG_PORTABLE
    const uint old = atomicAdd(sum.low, x.x);
    atomicAdd(sum.high, x.y + (old + x.x < old ? 1u : 0u));
#else
    atomicAdd(sum.value, packUint2x32(x));
#endif
}

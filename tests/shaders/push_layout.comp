// Only its interface matters: a push-constant block with nested types, and resources of every kind.
#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
layout(local_size_x = 4, local_size_y = 2, local_size_z = 3) in;
struct Inner { vec3 a; uint b[3]; };
layout(binding = 11) uniform samplerBuffer floats;
layout(binding = 3) uniform utextureBuffer uints;
layout(binding = 60, scalar) buffer Output { uint at[]; } result;
layout(push_constant, scalar) uniform Push { mat3 m; Inner inner; uint64_t big; float last; } push;

void main() { result.at[0] = uint(push.last) + uint(texelFetch(floats, 0).x) + texelFetch(uints, 0).x; }

// Lets one source compile as GLSL, as C++ with GLM in float and as C++ with GLM in double (tests/lib/shader_float.h, shader_double.h).
//
// Rules for every file that includes this one: OUT/INOUT for parameters that return values; no array constructors; no swizzle
// but .x .y .z .w; literals written 1.0 (the float build turns them into float); whole numbers that are hashed in files of their
// own. The C++ builds include the files inside a struct, so specialization constants become its members.
#ifndef CMPG_LIB_DUAL
#define CMPG_LIB_DUAL
#ifdef __cplusplus
#define OUT(T) T&
#define INOUT(T) T&
#define ZEROED = {}
#define PRECISE
#else
#define OUT(T) out T
#define INOUT(T) inout T
#define ZEROED
#define PRECISE precise // keeps error-free transformations from being simplified away
#endif
#endif

// One-line accessors for read-mostly hot data. Texel buffers are about twice as fast as storage buffers on lavapipe;
// the portable variant uses storage because some devices allow only 65 536 texels.
#extension GL_EXT_scalar_block_layout : require
#ifdef CMPG_PORTABLE
#define READ_VEC4(name, slot) \
    layout(binding = slot, scalar) readonly buffer name##Storage { vec4 at[]; } name##_; \
    vec4 name(uint i) { return name##_.at[i]; }
#define READ_UVEC4(name, slot) \
    layout(binding = slot, scalar) readonly buffer name##Storage { uvec4 at[]; } name##_; \
    uvec4 name(uint i) { return name##_.at[i]; }
#define READ_FLOAT(name, slot) \
    layout(binding = slot, scalar) readonly buffer name##Storage { float at[]; } name##_; \
    float name(uint i) { return name##_.at[i]; }
#define READ_UINT(name, slot) \
    layout(binding = slot, scalar) readonly buffer name##Storage { uint at[]; } name##_; \
    uint name(uint i) { return name##_.at[i]; }
#else
#define READ_VEC4(name, slot) \
    layout(binding = slot) uniform textureBuffer name##_; \
    vec4 name(uint i) { return texelFetch(name##_, int(i)); }
#define READ_UVEC4(name, slot) \
    layout(binding = slot) uniform utextureBuffer name##_; \
    uvec4 name(uint i) { return texelFetch(name##_, int(i)); }
#define READ_FLOAT(name, slot) \
    layout(binding = slot) uniform textureBuffer name##_; \
    float name(uint i) { return texelFetch(name##_, int(i)).x; }
#define READ_UINT(name, slot) \
    layout(binding = slot) uniform utextureBuffer name##_; \
    uint name(uint i) { return texelFetch(name##_, int(i)).x; }
#endif

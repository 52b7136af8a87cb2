// One-line accessors for what kernels read and do not write, in one of three ways that the build chooses (cmake/Shaders.cmake) and the device
// at its start (src/vk/device.cpp):
//     uniform texel buffers, on GPUs: their texture caches are made for reads at random;
//     CMPG_STORAGE_TEXELS: storage texel buffers, on CPU drivers, where a read at random costs half of one from a storage buffer and, in newer
//         Mesa, half of one from a uniform texel buffer as well, which goes through a sampler;
//     CMPG_PORTABLE: storage buffers, because some devices allow only 65 536 texels.
// READ_...: tables of the scene. QUEUE_...: what a kernel left for the next, in the order it is read; from storage buffers but on CPU drivers.
#extension GL_EXT_scalar_block_layout : require

#define READ_STORAGE(type, name, slot) \
    layout(binding = slot, scalar) readonly buffer name##Storage { type at[]; } name##_; \
    type name(uint i) { return name##_.at[i]; }

#if defined(CMPG_PORTABLE)
#define READ_VEC4(name, slot) READ_STORAGE(vec4, name, slot)
#define READ_UVEC4(name, slot) READ_STORAGE(uvec4, name, slot)
#define READ_FLOAT(name, slot) READ_STORAGE(float, name, slot)
#define READ_UINT(name, slot) READ_STORAGE(uint, name, slot)
#define QUEUE_UVEC4(name, slot) READ_STORAGE(uvec4, name, slot)
#define QUEUE_UINT(name, slot) READ_STORAGE(uint, name, slot)
#elif defined(CMPG_STORAGE_TEXELS)
#define READ_TEXELS(type, name, slot, images, format, components) \
    layout(binding = slot, format) uniform readonly restrict images name##_; \
    type name(uint i) { return imageLoad(name##_, int(i)).components; }
#define READ_VEC4(name, slot) READ_TEXELS(vec4, name, slot, imageBuffer, rgba32f, xyzw)
#define READ_UVEC4(name, slot) READ_TEXELS(uvec4, name, slot, uimageBuffer, rgba32ui, xyzw)
#define READ_FLOAT(name, slot) READ_TEXELS(float, name, slot, imageBuffer, r32f, x)
#define READ_UINT(name, slot) READ_TEXELS(uint, name, slot, uimageBuffer, r32ui, x)
#define QUEUE_UVEC4(name, slot) READ_UVEC4(name, slot)
#define QUEUE_UINT(name, slot) READ_UINT(name, slot)
#else
#define READ_TEXELS(type, name, slot, textures, components) \
    layout(binding = slot) uniform textures name##_; \
    type name(uint i) { return texelFetch(name##_, int(i)).components; }
#define READ_VEC4(name, slot) READ_TEXELS(vec4, name, slot, textureBuffer, xyzw)
#define READ_UVEC4(name, slot) READ_TEXELS(uvec4, name, slot, utextureBuffer, xyzw)
#define READ_FLOAT(name, slot) READ_TEXELS(float, name, slot, textureBuffer, x)
#define READ_UINT(name, slot) READ_TEXELS(uint, name, slot, utextureBuffer, x)
#define QUEUE_UVEC4(name, slot) READ_STORAGE(uvec4, name, slot)
#define QUEUE_UINT(name, slot) READ_STORAGE(uint, name, slot)
#endif

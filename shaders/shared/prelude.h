// Lets a header be read by GLSL and by C++. C++ gets GLSL's type names inside cmpg::gpu.
#ifndef CMPG_SHARED_PRELUDE
#define CMPG_SHARED_PRELUDE
#ifdef __cplusplus
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
namespace cmpg::gpu {
using glm::vec2, glm::vec3, glm::vec4, glm::uvec2, glm::uvec3, glm::uvec4, glm::ivec2;
using uint = std::uint32_t;
}
#define CMPG_SHARED_BEGIN namespace cmpg::gpu {
#define CMPG_SHARED_END }
#define CMPG_CONST constexpr uint
#else
#define CMPG_SHARED_BEGIN
#define CMPG_SHARED_END
#define CMPG_CONST const uint
#endif
#endif

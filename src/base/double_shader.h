// Names of GLSL for files of shaders/lib that the host compiles in double precision: in a namespace of their own, between
// `#define float double` and `#undef float`.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>

namespace cmpg::double_shader {

using namespace glm;
using vec2 = glm::dvec2;
using vec3 = glm::dvec3;
using vec4 = glm::dvec4;
using uvec4 = glm::u32vec4;
using uint = std::uint32_t;

} // namespace cmpg::double_shader

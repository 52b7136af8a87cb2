// The single-precision half of calls.h.
#include "lib/shader_float.h"

#include "calls.h"

cmpg::test::Numbers cmpg::test::callFloat(Function function, const std::vector<float>& arguments) {
    using shader_float::ShaderLibrary;
    using Real = float;
    using Vec2 = glm::vec2;
    using Vec3 = glm::vec3;
#include "calls.inc"
}

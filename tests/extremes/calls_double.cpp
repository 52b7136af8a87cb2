// The double-precision half of calls.h.
#include "lib/shader_double.h"

#include "calls.h"

cmpg::test::Numbers cmpg::test::callDouble(Function function, const std::vector<float>& arguments) {
    using shader_double::ShaderLibrary;
    using Real = double;
    using Vec2 = glm::dvec2;
    using Vec3 = glm::dvec3;
#include "calls.inc"
}

// Derivatives by differences, for functions of the shader library in double precision.
#pragma once

#include <functional>
#include <glm/glm.hpp>

namespace cmpg::test {

// Richardson's combination of two central differences.
inline glm::dvec3 difference(const std::function<glm::dvec3(double)>& f, double step) {
    const auto central = [&](double h) { return (f(h) - f(-h)) / (2 * h); };
    return (4.0 * central(step / 2) - central(step)) / 3.0;
}

} // namespace cmpg::test

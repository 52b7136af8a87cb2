// The maps from random numbers to directions, and frames, at the ends of their ranges.
#include "calls.h"
#include "worst.h"

#include <algorithm>
#include <glm/glm.hpp>
#include <sstream>

namespace cmpg::test {
namespace {

const float kNumbers[] = {0, 1e-40f, 6e-8f, 1e-3f, 0.25f, 0.5f, 0.75f, 0.9999f, 0.99999994f};

std::string list(const std::vector<float>& arguments) {
    std::ostringstream s;
    for (const float a : arguments) s << a << ' ';
    return s.str();
}

glm::dvec2 slope(const Numbers& normal) { return {normal[0] / normal[2], normal[1] / normal[2]}; }

TEST(ExtremeMaps, CosineHemisphere) {
    Worst worst("map | cosine-weighted direction | random numbers 0, 6e-8 to 1 - 6e-8", "float64", 1e-6);
    for (const float u : kNumbers)
        for (const float v : kNumbers) {
            const Numbers got = callFloat(Function::CosineHemisphere, {u, v}), truth = callDouble(Function::CosineHemisphere, {u, v});
            for (int i = 0; i < 3; ++i) worst.add(std::abs(got[i] - truth[i]), [&] { return list({u, v}); });
        }
}

// The slope of the drawn normal. Where the lobe's map stretches most, the next random number leads further away than 1e-4, and no
// formula in float can do better than a few such steps.
TEST(ExtremeMaps, VisibleNormals) {
    Worst worst("map | slope of a visible normal, per 1e-4 + two steps of the random numbers | alpha 1e-3 to 1; incidence to 89.9999 degrees; random numbers 0 to 1 - 6e-8", "float64", 1);
    for (const float alpha : {1e-3f, 1e-2f, 0.1f, 1.0f})
        for (const float cosine : {1.0f, 0.5f, 1e-2f, 1e-4f, 1.7e-6f, 1e-9f})
            for (const float u : kNumbers)
                for (const float v : kNumbers) {
                    const std::vector<float> arguments{alpha, std::sqrt(1 - cosine * cosine), 0, cosine, u, v};
                    const glm::dvec2 truth = slope(callDouble(Function::GgxNormal, arguments));
                    double step = 0;
                    for (const float du : {-1.2e-7f, 1.2e-7f})
                        for (const float dv : {-1.2e-7f, 1.2e-7f})
                            step = std::max(step, glm::length(slope(callDouble(Function::GgxNormal, {alpha, arguments[1], 0, cosine, u + du, std::clamp(v + dv, 0.0f, 0.99999994f)})) - truth));
                    const double error = glm::length(slope(callFloat(Function::GgxNormal, arguments)) - truth);
                    worst.add(error / (1e-4 * (double(alpha) + glm::length(truth)) + step), [&] { return list(arguments); });
                }
}

TEST(ExtremeMaps, Frames) {
    Worst worst("map | tangent frame, orthonormality | normals at and around both poles", "0 and 1", 1e-6);
    for (const double tilt : {0.0, 1e-30, 1e-8, 1e-4, 1e-3, 0.5, 1.5707963})
        for (const double turn : {0.0, 0.7, 1.5707963267948966, 3.0, -1.0})
            for (const double sign : {1.0, -1.0}) {
                const glm::vec3 n(glm::dvec3(std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), sign * std::cos(tilt)));
                const Numbers f = callFloat(Function::Frame, {n.x, n.y, n.z});
                const glm::dvec3 x(f[0], f[1], f[2]), y(f[3], f[4], f[5]), z(n);
                for (const double error : {glm::dot(x, y), glm::dot(x, z), glm::dot(y, z), glm::length(x) - 1, glm::length(y) - 1, glm::dot(glm::cross(x, y), z) - 1})
                    worst.add(std::abs(error), [&] { return list({n.x, n.y, n.z}); });
            }
}

} // namespace
} // namespace cmpg::test

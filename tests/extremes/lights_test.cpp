// Lights, environment maps, texture look-ups and the maps that sampling rests on, at the ends of their ranges.
#include "calls.h"
#include "worst.h"

#include <algorithm>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <sstream>

namespace cmpg::test {
namespace {

std::string list(const std::vector<float>& arguments) {
    std::ostringstream s;
    s.precision(9);
    for (const float a : arguments) s << a << ' ';
    return s.str();
}

// Each number relative to itself, or to `scale`.
void compare(Worst& worst, Function function, const std::vector<float>& arguments, double scale = 0) {
    const Numbers got = callFloat(function, arguments), truth = callDouble(function, arguments);
    for (std::size_t i = 0; i < got.size(); ++i)
        worst.compare(got[i], truth[i], [&] { return list(arguments) + "is " + std::to_string(got[i]) + ", truth " + std::to_string(truth[i]); }, scale);
}

TEST(ExtremeLights, Falloff) {
    const float distances2[] = {0, 1e-37f, 1e-30f, 1e-12f, 1e-8f, 1, 1e8f, 1e12f, 1e30f};
    {
        Worst worst("light | inverse square with range | squared distance 0, 1e-37 to 1e30; range 0, 1e-6 to 1e18", "float64", 1e-4);
        for (const float d : distances2)
            for (const float range : {0.0f, 1e-6f, 1e-3f, 1.0f, 1e3f, 1e15f, 1e18f})
                compare(worst, Function::DistanceFalloff, {d, range}, d > 0 ? 1e-3 / double(d) : 0); // the window crosses zero
    }
    {
        Worst worst("light | spot | cones from 0 to 180 degrees, also without a rim", "float64", 1e-4);
        for (const float inner : {1.0f, 0.9999999f, 0.5f, 0.0f, -1.0f})
            for (const float width : {0.0f, 1e-7f, 1e-3f, 0.5f})
                for (const float cosine : {1.0f, 0.99999994f, 0.99f, 0.5f, 0.4999f, 0.2f, -1.0f})
                    compare(worst, Function::SpotFalloff, {cosine, inner, inner - width}, 0.01); // the rim crosses zero
    }
    {
        Worst worst("light | density per solid angle | cosine 1e-12 to 1; squared distance 1e-30 to 1e30; area 1e-12 to 1e12", "float64", 1e-4);
        for (const float density : {1e-12f, 1e-6f, 1.0f, 1e6f, 1e12f})
            for (const float d : {1e-18f, 1e-8f, 1.0f, 1e12f, 1e18f})
                for (const float cosine : {-1.0f, 0.0f, 1e-12f, 1e-8f, 1.7e-6f, 1e-3f, 1.0f}) {
                    if (double(density) * double(d) / std::max(double(cosine), 1e-9) > 1e38) continue; // caught and counted by the caller
                    compare(worst, Function::AreaToSolidAngle, {density, d, cosine});
                }
    }
}

TEST(ExtremeLights, MultipleImportance) {
    Worst worst("light | weight of two techniques | densities 0, 1e-40 to 3e38, infinite", "float64", 1e-4);
    const float densities[] = {0, 1e-40f, 1e-37f, 1e-20f, 1e-6f, 1, 1e6f, 1e20f, 3e38f, std::numeric_limits<float>::infinity()};
    for (const float own : densities)
        for (const float other : densities) {
            const double got = callFloat(Function::MisWeight, {own, other})[0];
            const double back = callFloat(Function::MisWeight, {other, own})[0];
            const auto where = [&] { return list({own, other}); };
            worst.add(own == 0 && other == 0 ? got : std::abs(got + back - 1), where);
            if (std::isfinite(own) && std::isfinite(other)) worst.compare(got, callDouble(Function::MisWeight, {own, other})[0], where);
        }
}

std::vector<glm::vec3> directions() {
    std::vector<glm::vec3> all;
    for (const double tilt : {0.0, 1e-30, 1e-8, 1e-6, 1e-4, 0.1, 1.0, 1.5707963, 3.0, 3.14159})
        for (const double turn : {0.0, 1e-30, 1e-7, 1e-3, 1.0, 1.5707963267948966, 2.0, 3.1415926, 3.141592653589793, -3.1415926, -1e-7, -1e-30})
            for (const double sign : {1.0, -1.0}) {
                const glm::dvec3 d(std::sin(tilt) * std::sin(turn), sign * std::cos(tilt), -std::sin(tilt) * std::cos(turn));
                all.emplace_back(d);
            }
    all.insert(all.end(), {{0, 1, 0}, {0, -1, 0}, {-0.0f, 1, -0.0f}, {1, 0, 0}, {-1, 0, 0}, {0, 0, 1}, {0, 0, -1}, {1e-40f, 1, 1e-40f}});
    return all;
}

// Positions on the map are compared as directions: at a pole the longitude means nothing.
TEST(ExtremeLights, EnvironmentMap) {
    {
        Worst uv("environment | direction to map | poles, seam, axes", "float64", 1e-4);
        for (const glm::vec3& d : directions()) {
            const Numbers got = callFloat(Function::EnvironmentUv, {d.x, d.y, d.z}), truth = callDouble(Function::EnvironmentUv, {d.x, d.y, d.z});
            const auto where = [&] { return list({d.x, d.y, d.z}) + std::to_string(got[0]) + ' ' + std::to_string(got[1]); };
            const double turn = std::abs(got[0] - truth[0]), level = std::abs(got[1] - truth[1]);
            const double radius = std::hypot(double(d.x), double(d.z)), theta = std::atan2(radius, std::abs(double(d.y)));
            uv.add(got[0] >= 0 && got[0] <= 1 ? std::min(turn, 1 - turn) : 1, where);
            uv.add(d.y > 0 ? level * glm::pi<double>() / std::max(theta, 1e-15) : level, where); // relative to the angle from the upper pole
        }
    }
    {
        Worst linear("environment | number with a linear density | ratios of 1 to 37", "float64", 1e-4);
        for (const float u : {0.0f, 6e-8f, 1e-3f, 0.5f, 0.99999994f})
            for (const auto& [a, b] : {std::pair{1.0f, 1.0f}, {0.1f, 3.7f}, {3.7f, 0.1f}, {1.0f, 1.0000001f}}) compare(linear, Function::SampleLinear, {u, a, b});
    }
    {
        Worst sample("environment | direction in a row | 4096 rows, at the poles and between", "float64", 1e-4);
        for (const float row : {0.0f, 1.0f, 17.0f, 2047.0f, 4093.0f, 4094.0f})
            for (const float across : {0.0f, 6e-8f, 0.25f, 0.5f, 0.99999994f})
                for (const float down : {0.0f, 6e-8f, 0.5f, 0.99999994f}) {
                    const std::vector<float> arguments{across, row, down, 4096};
                    const Numbers got = callFloat(Function::EnvironmentPoint, arguments), truth = callDouble(Function::EnvironmentPoint, arguments);
                    // As a share of the distance from the pole, where the map is finest.
                    const double radius = std::max(std::hypot(truth[0], truth[2]), 1e-30);
                    const double error = std::hypot(got[0] - truth[0], got[2] - truth[2]);
                    sample.add(error <= 1e-30 ? 0 : error / radius, [&] { return list(arguments); });
                    sample.add(std::abs(std::sqrt(got[0] * got[0] + got[1] * got[1] + got[2] * got[2]) - 1), [&] { return list(arguments); });
                }
    }
}

// A unit of error is a texel's weight; the reason for the bounds is the coordinate, which in float resolves 6e-8 of the image.
TEST(ExtremeTextures, Filtering) {
    const float coordinates[] = {0, 1e-40f, 1e-30f, 1e-9f, 6e-5f, 0.25f, 0.5f, 0.99999994f, 1, 1.0000001f, 2, -1e-30f, -1e-9f, -0.25f, -1, 17.3f, -1234.5f};
    struct Size {
        float width, height;
        const char* range;
        double bound;
    };
    for (const Size& size : {Size{1, 1, "1 x 1", 1e-6}, Size{2, 3, "2 x 3", 1e-6}, Size{1024, 1, "1024 x 1", 1e-6}, Size{8192, 8192, "8192 x 8192", 1e-6}, Size{7001, 8191, "7001 x 8191", 1e-4}}) {
        Worst worst(std::string("texture | filtered value | ") + size.range + ", coordinates -1234 to 17", "float64", size.bound);
        for (const float u : coordinates)
            for (const float v : coordinates)
                for (float wrapU = 0; wrapU < 3; ++wrapU)
                    for (float wrapV = 0; wrapV < 3; ++wrapV) {
                        const std::vector<float> arguments{u, v, size.width, size.height, wrapU, wrapV, 0};
                        const double got = callFloat(Function::TexelValue, arguments)[0], truth = callDouble(Function::TexelValue, arguments)[0];
                        worst.add(std::abs(got - truth) / truth, [&] { return list(arguments) + std::to_string(got) + " truth " + std::to_string(truth); });
                    }
    }
}

} // namespace
} // namespace cmpg::test

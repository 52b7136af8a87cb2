// Origins of new rays in the float build, at all scales.
#include "shader_float.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace cmpg::test {
namespace {

using Library = shader_float::ShaderLibrary;

glm::dvec3 randomDirection(std::mt19937& random) {
    std::normal_distribution<double> normal;
    const double x = normal(random), y = normal(random), z = normal(random);
    return glm::normalize(glm::dvec3(x, y, z));
}

// Points of random triangles, moved away from the origin and scaled: the new origin is strictly on the ray's side of the true
// plane (in double), and no farther from it than 1e-5 of the scene's coordinates.
TEST(RayOffset, LeavesTheSurfaceAtEveryScale) {
    Library library;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < 300000; ++i) {
        const double size = std::pow(10, 10 * uniform(random) - 4), away = i % 2 ? 0 : size * std::pow(10, 4 * uniform(random) - 2);
        const glm::dvec3 center = away * randomDirection(random);
        glm::vec3 v[3];
        for (glm::vec3& p : v) p = glm::vec3(center + size * uniform(random) * randomDirection(random));
        const glm::vec3 e1 = v[1] - v[0], e2 = v[2] - v[0];
        const glm::dvec3 exact = glm::cross(glm::dvec3(e1), glm::dvec3(e2));
        if (glm::length(exact) < 1e-2 * glm::length(glm::dvec3(e1)) * glm::length(glm::dvec3(e2))) continue; // slivers have no normal in float
        const float b = std::sqrt(float(uniform(random))), c = b * float(uniform(random));
        const glm::vec3 hit = v[0] + (b - c) * e1 + c * e2;
        const glm::vec3 normal = glm::normalize(glm::cross(e1, e2)), direction(randomDirection(random));
        float magnitude = 0;
        for (const glm::vec3& p : v) magnitude = std::max(magnitude, library.largestCoordinate(p));
        const glm::vec3 origin = library.offsetRayOrigin(hit, normal, direction, magnitude);
        const double side = glm::dot(normal, direction) < 0 ? -1 : 1;
        // The plane the traversal sees: through v[0], spanned by the rounded edges.
        const double height = side * glm::dot(glm::normalize(exact), glm::dvec3(origin) - glm::dvec3(v[0]));
        ASSERT_GT(height, 0) << "size " << size << " away " << away;
        ASSERT_LT(height, 1e-5 * double(magnitude));
    }
}

} // namespace
} // namespace cmpg::test

// Rays and boxes in the float build, against points drawn in and about the box.
#include "shader_float.h"

#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace cmpg::test {
namespace {

using Library = shader_float::ShaderLibrary;
using glm::vec3;

// Towards a point inside, from anywhere, along an axis, too: crosses. Away from a box that does not hold the origin: does not.
TEST(Box, RaysTowardsItCrossIt) {
    Library library;
    std::mt19937 random(5);
    std::uniform_real_distribution<float> inside(0.01f, 0.99f), anywhere(-3, 3);
    for (int i = 0; i < 100000; ++i) {
        const vec3 low(anywhere(random), anywhere(random), anywhere(random));
        const vec3 size(inside(random), inside(random), i % 3 == 0 ? 0 : inside(random)); // one in three is flat
        const vec3 aim = low + size * vec3(inside(random), inside(random), inside(random));
        vec3 origin(anywhere(random), anywhere(random), anywhere(random));
        if (i % 5 == 0)
            origin = vec3(aim.x, aim.y, origin.z);
        const vec3 margin(1e-5f), direction = aim - origin;
        if (direction == vec3(0))
            continue;
        ASSERT_TRUE(library.crossesBox(origin, direction, low - margin, low + size + margin)) << i;
        const bool within = glm::all(glm::greaterThanEqual(origin, low - margin)) && glm::all(glm::lessThanEqual(origin, low + size + margin));
        ASSERT_EQ(library.crossesBox(origin, -direction, low - margin, low + size + margin), within) << i;
    }
}

TEST(Box, RaysPastItDoNot) {
    Library library;
    const vec3 low(-1), high(1);
    EXPECT_FALSE(library.crossesBox(vec3(0, 1.1f, -3), vec3(0, 0, 1), low, high));
    EXPECT_FALSE(library.crossesBox(vec3(0, 1.1f, -3), vec3(0, 1e-30f, 1), low, high));
    EXPECT_FALSE(library.crossesBox(vec3(-3, -2.1f, 0), vec3(1, 2, 0), low, high)); // enters one slab after it left another
    EXPECT_TRUE(library.crossesBox(vec3(-3, -1.9f, 0), vec3(1, 1, 0), low, high));
}

TEST(Box, NothingCrossesAnEmptyOne) {
    Library library;
    std::mt19937 random(6);
    std::uniform_real_distribution<float> anywhere(-1, 1);
    const vec3 all(std::numeric_limits<float>::infinity());
    for (int i = 0; i < 1000; ++i) {
        const vec3 direction(i % 2 ? anywhere(random) : 0, anywhere(random), anywhere(random));
        EXPECT_FALSE(library.crossesBox(vec3(anywhere(random)), direction, all, -all));
    }
}

} // namespace
} // namespace cmpg::test

// Student's t against its closed forms.
#include "base/student_t.h"

#include <cmath>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

TEST(StudentT, MatchesClosedForms) {
    for (const double t : {0.0, 0.1, 1.0, 2.5, 7.0, 40.0}) {
        EXPECT_NEAR(studentTwoSided(t, 1), 1 - 2 * std::atan(t) / M_PI, 1e-8) << t; // Cauchy
        EXPECT_NEAR(studentTwoSided(t, 2), 1 - t / std::sqrt(2 + t * t), 1e-10) << t;
        const double a = std::atan(t / 2); // 4 degrees: 1 - sin a (1 + cos^2 a / 2)
        EXPECT_NEAR(studentTwoSided(t, 4), 1 - std::sin(a) * (1 + std::cos(a) * std::cos(a) / 2), 1e-10) << t;
        EXPECT_NEAR(studentTwoSided(t, 1e7), std::erfc(t / std::sqrt(2)), 1e-6) << t; // the normal limit
        EXPECT_DOUBLE_EQ(studentTwoSided(t, 7), studentTwoSided(-t, 7));
    }
    EXPECT_NEAR(studentTwoSided(4, 1e7), 6.334e-5, 1e-8); // the four standard deviations of gradient_check.cpp
}

TEST(StudentT, WhatIsNoNumberHasNoProbability) {
    EXPECT_TRUE(std::isnan(studentTwoSided(std::nan(""), 3)));
    EXPECT_TRUE(std::isnan(studentTwoSided(1, std::nan(""))));
    EXPECT_EQ(studentTwoSided(HUGE_VAL, 3), 0);
    EXPECT_EQ(studentTwoSided(-HUGE_VAL, 3), 0);
}

} // namespace
} // namespace cmpg

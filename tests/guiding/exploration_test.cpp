// When trials of other methods of sampling are allowed.
#include "guiding/policy/exploration.h"

#include <gtest/gtest.h>

#include <limits>

namespace cmpg {
namespace {

TEST(Exploration, WatchesTheFirstStepsAndEveryEighth) {
    const Exploration exploration;
    for (std::uint32_t step = 0; step < 40; ++step)
        EXPECT_EQ(exploration.watches(step), step < 3 || step % 8 == 0) << step;
}

TEST(Exploration, LeavesPreciseGradientsAlone) {
    Exploration exploration;
    exploration.spend(1e12, 0);
    EXPECT_FALSE(exploration.allows(0)); // nothing is known
    for (int i = 0; i < 20; ++i)
        exploration.observeNoise(0.1);
    EXPECT_FALSE(exploration.allows(0));
}

TEST(Exploration, SparesNothingWhereTheFirstGradientsAreNoise) {
    Exploration exploration;
    exploration.observeNoise(24);
    EXPECT_TRUE(exploration.allows(2));
    for (int i = 0; i < 20; ++i)
        exploration.observeNoise(0.1); // trials that began go on
    EXPECT_TRUE(exploration.allows(2));
    Exploration later; // once a recovery comes to its end, all gradients are noise
    for (int i = 0; i < 5; ++i)
        later.observeNoise(0.1);
    for (int i = 0; i < 20; ++i)
        later.observeNoise(24);
    EXPECT_FALSE(later.allows(0));
    Exploration asked;
    asked.hurry();
    EXPECT_TRUE(asked.allows(2));
}

// In between, trials get a tenth of all rays.
TEST(Exploration, KeepsToItsShare) {
    Exploration exploration;
    exploration.observeNoise(0.5);
    EXPECT_FALSE(exploration.allows(0));
    exploration.spend(19 * kKernelRays, 0);
    EXPECT_FALSE(exploration.allows(2));
    exploration.spend(2 * kKernelRays, 0);
    EXPECT_TRUE(exploration.allows(2));
    exploration.spend(2 * kKernelRays, 2.2 * kKernelRays);
    EXPECT_TRUE(exploration.allows(0));
    EXPECT_FALSE(exploration.allows(1));
    Exploration restored;
    restored.restore(exploration.state());
    EXPECT_TRUE(restored.allows(0));
    EXPECT_FALSE(restored.allows(1));
}

TEST(Exploration, AveragesTheNoise) {
    Exploration exploration;
    exploration.observeNoise(0.5);
    exploration.observeNoise(0.9);
    EXPECT_DOUBLE_EQ(exploration.state().noise, 0.7);
    exploration.observeNoise(std::numeric_limits<double>::quiet_NaN());
    EXPECT_DOUBLE_EQ(exploration.state().noise, 0.7);
    for (int i = 0; i < 30; ++i)
        exploration.observeNoise(0.2);
    EXPECT_NEAR(exploration.state().noise, 0.2, 1e-4);
}

} // namespace
} // namespace cmpg

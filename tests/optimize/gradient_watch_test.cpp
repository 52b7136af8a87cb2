// Warnings about gradients: each comes once, when its cause lasts, and not without.
#include "optimize/gradient_watch.h"

#include <gtest/gtest.h>
#include <random>

namespace cmpg {
namespace {

class Watched {
  public:
    // Events of `steps` steps like this.
    std::vector<std::string> steps(int count, double norm, double loss, double concentration = 0.01, double lossError = 0) {
        std::vector<std::string> events;
        for (int i = 0; i < count; ++i) {
            StepReport report;
            report.loss = loss;
            report.lossError = lossError;
            report.gradientNorm = {norm * (0.5 + uniform_(random_))};
            report.concentration = concentration;
            for (const v1::Warning& f : watch_.observe(report)) {
                EXPECT_FALSE(f.options.empty()) << f.text; // a remedy
                events.push_back(f.event);
            }
        }
        return events;
    }

  private:
    GradientWatch watch_;
    std::mt19937 random_{3};
    std::uniform_real_distribution<double> uniform_;
};

using Events = std::vector<std::string>;

TEST(GradientWatch, IsSilentWhileALossFalls) {
    Watched run;
    double loss = 1, norm = 1;
    for (int i = 0; i < 500; ++i, loss *= 0.97, norm *= 0.9)
        EXPECT_EQ(run.steps(1, norm, loss), Events()) << i; // to the end: a gradient of nothing is no stall where the loss is found
}

// Every fourth loss a hundred times the others', as where few paths find the light.
TEST(GradientWatch, IsSilentOnNoise) {
    Watched run;
    for (int i = 0; i < 500; ++i)
        EXPECT_EQ(run.steps(1, i % 4 ? 1 : 20, i % 4 ? 1 : 100, i % 8 ? 0.6 : 0.3), Events()) << i;
}

TEST(GradientWatch, TellsOnceOfExplosions) {
    Watched run;
    EXPECT_EQ(run.steps(40, 1, 1), Events());
    EXPECT_EQ(run.steps(2, 1000, 1), Events()); // two steps may be chance
    EXPECT_EQ(run.steps(10, 1000, 1), Events{"gradients_explode"});
    Watched other;
    EXPECT_EQ(other.steps(40, 1, 0.01), Events());
    EXPECT_EQ(other.steps(40, 1, 1), Events{"gradients_explode"}); // a loss that left its minimum
    EXPECT_EQ(other.steps(40, 1, 0.01), Events());
    EXPECT_EQ(other.steps(40, 1, 1), Events{"gradients_explode"}); // once more, after it was over
}

// At the end of a good run a loss without bias is what is left of its noise: a small number, whatever multiple of the lowest.
TEST(GradientWatch, IsSilentWhereNoiseIsAllThatIsLeft) {
    Watched run;
    EXPECT_EQ(run.steps(40, 1, 1e-6, 0.01, 5e-5), Events());
    EXPECT_EQ(run.steps(40, 1, 1e-4, 0.01, 5e-5), Events());
    Watched precise;
    EXPECT_EQ(precise.steps(40, 1, 1e-6, 0.01, 1e-6), Events());
    EXPECT_EQ(precise.steps(40, 1, 1e-4, 0.01, 1e-6), Events{"gradients_explode"});
    Watched below;
    EXPECT_EQ(below.steps(40, 1, -1e-6, 0.01, 1e-6), Events());
    EXPECT_EQ(below.steps(40, 1, 1, 0.01, 1e-6), Events{"gradients_explode"});
}

TEST(GradientWatch, TellsOfStalls) {
    Watched run;
    EXPECT_EQ(run.steps(40, 1, 1), Events());
    EXPECT_EQ(run.steps(40, 0, 0.9), Events{"gradients_stall"});
    Watched found;
    EXPECT_EQ(found.steps(40, 1, 1), Events());
    EXPECT_EQ(found.steps(100, 0, 0.001), Events());
}

// Steps that arrive before there are losses enough to compare: what is left is noise, and gradients of nothing are no stall.
TEST(GradientWatch, IsSilentWhereTheFirstStepsArrive) {
    Watched run;
    EXPECT_EQ(run.steps(2, 1, 100), Events());
    for (int i = 0; i < 100; ++i)
        EXPECT_EQ(run.steps(1, 1e-9, i % 3 ? 2e-6 : -1e-6, 0.01, 3e-6), Events()) << i;
}

TEST(GradientWatch, TellsOfGradientsOfAFewSamples) {
    Watched run;
    EXPECT_EQ(run.steps(40, 1, 1, 0.2), Events());
    EXPECT_EQ(run.steps(15, 1, 1, 0.9), Events());
    EXPECT_EQ(run.steps(20, 1, 1, 0.9), Events{"gradients_noisy"});
    Watched rare; // steps between that measure nothing tell nothing
    int events = 0;
    for (int i = 0; i < 40; ++i)
        events += int(rare.steps(1, 1, 1, i % 2 ? 0.9 : 0).size());
    EXPECT_EQ(events, 1);
}

} // namespace
} // namespace cmpg

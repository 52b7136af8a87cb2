// Steps of an optimisation where no guide pays.
#include "render/guided_passes.h"
#include "support/guided_fixture.h"

namespace cmpg::test {
namespace {

// Steps leave no records but for the steps before a trial, and are unguided passes to the bit.
TEST(GuidedPasses, RestWhereNoGuidePays) {
    constexpr std::uint32_t kSpp = 8;
    GuidedBench s("box", {"painting.baseColor"}, 32);
    GuidedPasses passes(*s.renderer, {.pixels = PixelSampling::Uniform, .roulette = false});
    passes.setLearning(true);
    std::vector<std::uint32_t> learned;
    std::vector<std::vector<double>> resting;
    for (std::uint32_t step = 0; step < 35; ++step) {
        const std::uint32_t updates = s.renderer->guide().updates();
        passes.render(s.view, kSpp, {5, step, 0});
        std::vector<std::vector<double>> gradient;
        passes.reverse(s.view, kSpp, {5, step, 1}, s.adjoint, gradient);
        if (step == 20) {
            resting = gradient;
            EXPECT_EQ(passes.concentration(), 0); // not measured
        }
        passes.endStep();
        if (s.renderer->guide().updates() > updates)
            learned.push_back(step);
    }
    EXPECT_EQ(passes.decision().kind, Sampling::Bsdf);
    EXPECT_EQ(learned, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5, 28, 29, 30, 31, 32})); // three ways twice, then a trial
    s.renderer->setSampling({});
    EXPECT_EQ(resting, s.gradient(kSpp, {5, 20, 1}));
}

} // namespace
} // namespace cmpg::test

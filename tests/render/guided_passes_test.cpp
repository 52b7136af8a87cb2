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

// Steps, and what they decide, are the same to the bit whether or not images are drawn in between.
TEST(GuidedPasses, PicturesTeachNothing) {
    const auto gradients = [](bool pictures) {
        GuidedBench s("box", {"painting.baseColor"}, 32);
        GuidedPasses passes(*s.renderer, {.pixels = PixelSampling::Uniform});
        passes.setLearning(true);
        std::vector<std::vector<double>> all;
        for (std::uint32_t step = 0; step < 4; ++step) {
            passes.render(s.view, 4, {5, step, 0});
            if (pictures)
                passes.picture(s.view, 4, {5, ~0u, 0});
            std::vector<std::vector<double>> gradient;
            passes.reverse(s.view, 4, {5, step, 1}, s.adjoint, gradient);
            if (pictures)
                passes.picture(s.view, 4, {5, ~0u, 0});
            all.push_back(gradient.front());
            passes.endStep();
            passes.publish();
        }
        all.emplace_back();
        for (const GuideCell& cell : s.renderer->guide().cells())
            all.back().push_back(cell.weight());
        return all;
    };
    EXPECT_EQ(gradients(true), gradients(false));
}

// The kernels of recording passes, which it takes where they are compiled already, draw the image that others draw.
TEST(GuidedPasses, PicturesAreThoseOfPlainPasses) {
    GuidedBench s("box", {"painting.baseColor"}, 32);
    GuidedPasses passes(*s.renderer, {});
    passes.setLearning(true);
    passes.prepareNext(Renderer::Mode::Render);
    ASSERT_FALSE(s.renderer->isPrepared(Renderer::Mode::Render, {}));
    const Image picture = passes.picture(s.view, 4, {5, 0, 0});
    EXPECT_FALSE(s.renderer->isPrepared(Renderer::Mode::Render, {})); // nothing else was compiled
    s.renderer->setSampling({});
    EXPECT_EQ(picture.values, s.renderer->render(s.view, 4, {5, 0, 0}).values);
}

// Kernels made ahead, by another thread, are those that the pass would have made.
TEST(GuidedPasses, TakeUpKernelsMadeAhead) {
    GuidedBench ahead("box", {"painting.baseColor"}, 32), other("box", {"painting.baseColor"}, 32);
    GuidedPasses passes(*ahead.renderer, {});
    passes.prepareAhead({Renderer::Mode::Render, Renderer::Mode::Reverse});
    passes.prepareAhead({Renderer::Mode::Reverse}); // twice does no harm
    const Image image = passes.render(ahead.view, 4, {5, 0, 0});
    EXPECT_EQ(image.values, other.renderer->render(other.view, 4, {5, 0, 0}).values);
    EXPECT_EQ(ahead.gradient(4, {5, 0, 1}), other.gradient(4, {5, 0, 1}));
}

} // namespace
} // namespace cmpg::test

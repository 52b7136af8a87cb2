// Steps of an optimisation where no guide pays.
#include "render/guided_passes.h"
#include "guiding/policy/pass_differences.h"
#include "render/pass_halves.h"
#include "support/guided_fixture.h"

namespace cmpg::test {
namespace {

// The mean of two halves with numbers of their own.
std::vector<std::vector<double>> inHalves(GuidedBench& s, std::uint32_t spp, const PassKey& key) {
    std::vector<std::vector<double>> mean = s.gradient(spp / 2, key), second = s.gradient(spp / 2, {key.seed, key.step, key.pass + 5});
    for (std::size_t p = 0; p < mean.size(); ++p)
        for (std::size_t k = 0; k < mean[p].size(); ++k)
            mean[p][k] = 0.5 * (mean[p][k] + second[p][k]);
    return mean;
}

// Gradients that are precise already: no step leaves records, and all are unguided passes to the bit. Some are halved to watch their noise.
TEST(GuidedPasses, TryNothingWhereGradientsArePrecise) {
    constexpr std::uint32_t kSpp = 64;
    GuidedBench s("box", {"painting.baseColor"}, 32), other("box", {"painting.baseColor"}, 32);
    GuidedPasses passes(*s.renderer, {.pixels = PixelSampling::Uniform});
    passes.setLearning(true);
    for (std::uint32_t step = 0; step < 10; ++step) {
        passes.renderHalves(s.view, 2, {5, step, 0}, false);
        std::vector<std::vector<double>> gradient;
        EXPECT_EQ(passes.reverse(s.view, kSpp, {5, step, 1}, s.adjoint, gradient), kSpp * 32u * 32u);
        passes.endStep();
        EXPECT_EQ(gradient, step < 3 || step == 8 ? inHalves(other, kSpp, {5, step, 1}) : other.gradient(kSpp, {5, step, 1})) << step;
        EXPECT_EQ(passes.unprepared({Renderer::Mode::Render, Renderer::Mode::Reverse}), 0u) << step;
    }
    EXPECT_EQ(s.renderer->guide().updates(), 0u);
    EXPECT_GT(passes.state().exploration.noise, 0);
    EXPECT_LT(passes.state().exploration.noise, 0.25);
    EXPECT_EQ(passes.state().exploration.watched, 4u);
}

// One sample, most of whose gradient is noise: the second step learns already, and the other methods follow.
TEST(GuidedPasses, TryAllWaysWhereGradientsAreNoise) {
    GuidedBench s("door", {"painting.baseColor"}, 32);
    GuidedPasses passes(*s.renderer, {});
    passes.setLearning(true);
    const auto step = [&](std::uint32_t number) {
        passes.renderHalves(s.view, 2, {5, number, 0}, false);
        std::vector<std::vector<double>> gradient;
        passes.reverse(s.view, 2, {5, number, 1}, s.adjoint, gradient);
        passes.endStep();
    };
    const auto unprepared = [&] { return passes.unprepared({Renderer::Mode::Render, Renderer::Mode::Reverse}); };
    EXPECT_EQ(unprepared(), 2u);
    step(0);
    EXPECT_EQ(unprepared(), 2u); // those that record
    EXPECT_TRUE(passes.state().exploration.urgent);
    EXPECT_EQ(s.renderer->guide().updates(), 0u);
    for (std::uint32_t i = 1; i < 10; ++i)
        step(i);
    EXPECT_GE(s.renderer->guide().updates(), 5u); // three that learn, two guided ways with roulette
    EXPECT_GE(passes.decision().rouletteFigures.size(), 2u);
    EXPECT_GT(passes.state().exploration.trials, 2 * kKernelRays);
    EXPECT_LT(passes.state().exploration.trials, passes.state().exploration.spent);
}

// Light that only chance finds: an image's noise is a few bright pixels, too few to tell its variance from. Methods are measured all the same, or such images
// would never be guided.
TEST(GuidedPasses, MeasureImagesWhoseNoiseIsAFewPixels) {
    RenderConfig config = guidedConfig();
    config.lightSampling = false;
    GuidedBench s("box", {"painting.baseColor"}, 6, config);
    GuidedPasses passes(*s.renderer, {.immediate = true});
    passes.setLearning(true);
    EXPECT_EQ(passes.imageVariance(Sampling::Bsdf), 0); // nothing was measured yet
    for (std::uint32_t step = 0; step < 4; ++step) {
        const ImageHalves halves = passes.renderHalves(s.view, 2, {5, step, 0}, false);
        ASSERT_FALSE(PassDifferences::compare(entries(halves.half[0].image), entries(halves.half[1].image)).telling) << step;
        std::vector<std::vector<double>> gradient;
        passes.reverse(s.view, 16, {5, step, 1}, s.adjoint, gradient);
        passes.endStep();
    }
    const SamplingDecision decision = passes.imageDecision();
    ASSERT_EQ(decision.figures.size(), 2u);
    for (const auto& [method, figures] : decision.figures) {
        EXPECT_GE(figures.passes, 1u);
        EXPECT_EQ(passes.imageVariance(method), figures.variance);
    }
}

// A restored state goes on as the one it was taken from, in the midst of the trials.
TEST(GuidedPasses, GoOnFromTheirState) {
    constexpr std::uint32_t kSteps = 8;
    const auto gradients = [](std::uint32_t restoreAt) {
        GuidedBench s("door", {"painting.baseColor"}, 32), later("door", {"painting.baseColor"}, 32);
        auto passes = std::make_unique<GuidedPasses>(*s.renderer, GuidedOptions{});
        GuidedBench* bench = &s;
        std::vector<std::vector<double>> all;
        for (std::uint32_t step = 0; step < kSteps; ++step) {
            if (step == restoreAt) {
                auto other = std::make_unique<GuidedPasses>(*later.renderer, GuidedOptions{});
                other->restore(passes->state(), s.renderer->guide());
                passes = std::move(other);
                bench = &later;
            }
            passes->setLearning(true);
            passes->renderHalves(bench->view, 2, {5, step, 0}, false);
            std::vector<std::vector<double>> gradient;
            passes->reverse(bench->view, 2, {5, step, 1}, bench->adjoint, gradient);
            all.push_back(gradient.front());
            passes->endStep();
            passes->publish();
        }
        return all;
    };
    const auto whole = gradients(kSteps); // never
    for (const std::uint32_t restoreAt : {2u, 5u})
        EXPECT_EQ(gradients(restoreAt), whole) << restoreAt;
}

// Steps leave no records but for the steps before a trial, and are unguided passes to the bit.
TEST(GuidedPasses, RestWhereNoGuidePays) {
    constexpr std::uint32_t kSpp = 8;
    GuidedBench s("box", {"painting.baseColor"}, 32);
    GuidedPasses passes(*s.renderer, {.pixels = PixelSampling::Uniform, .roulette = false, .immediate = true});
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
    EXPECT_EQ(passes.decision().method.kind, Sampling::Bsdf);
    EXPECT_EQ(learned, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 28, 29, 30, 31, 32})); // three that learn, two ways, then a trial
    s.plan = {};
    EXPECT_EQ(resting, s.gradient(kSpp, {5, 20, 1}));
}

// Steps, and what they decide, are the same to the bit whether or not images are drawn in between.
TEST(GuidedPasses, PicturesTeachNothing) {
    const auto gradients = [](bool pictures) {
        GuidedBench s("box", {"painting.baseColor"}, 32);
        GuidedPasses passes(*s.renderer, {.pixels = PixelSampling::Uniform, .immediate = true});
        passes.setLearning(true);
        std::vector<std::vector<double>> all;
        for (std::uint32_t step = 0; step < 6; ++step) {
            passes.render(s.view, 4, {5, step, 0});
            if (pictures)
                passes.picture(s.view, 4, {5, ~0u, 0}, false);
            std::vector<std::vector<double>> gradient;
            passes.reverse(s.view, 16, {5, step, 1}, s.adjoint, gradient);
            if (pictures)
                passes.picture(s.view, 4, {5, ~0u, 0}, false);
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
    for (const Renderer::Mode mode : {Renderer::Mode::Render, Renderer::Mode::Difference}) {
        const bool difference = mode == Renderer::Mode::Difference;
        RenderConfig config = guidedConfig();
        config.differences = difference;
        GuidedBench s("box", {"painting.baseColor"}, 32, config);
        GuidedPasses passes(*s.renderer, {.immediate = true});
        passes.setLearning(true);
        passes.prepareNext(mode);
        ASSERT_FALSE(s.renderer->isPrepared(mode, {}));
        const Image picture = passes.picture(s.view, 4, {5, 0, 0}, difference);
        EXPECT_FALSE(s.renderer->isPrepared(Renderer::Mode::Render, {})); // nothing else was compiled
        EXPECT_FALSE(s.renderer->isPrepared(mode, {}));
        const PassKey key{5, 0, 0};
        EXPECT_EQ(picture.values, (difference ? s.renderer->renderDifference(s.view, 4, key).image : s.renderer->render(s.view, 4, key)).values);
    }
}

// A renderer without a guide has no records to forget.
TEST(GuidedPasses, AbandonStepsWithoutAGuide) {
    RenderConfig config = guidedConfig();
    config.guiding = false;
    GuidedBench s("box", {"painting.baseColor"}, 8, config);
    GuidedPasses passes(*s.renderer, {.sampling = Sampling::Bsdf, .roulette = false});
    const auto step = [&] {
        std::vector<std::vector<double>> gradient;
        passes.reverse(s.view, 2, {5, 0, 1}, s.adjoint, gradient);
        return gradient;
    };
    const auto first = step();
    EXPECT_NO_THROW(passes.abandonStep());
    EXPECT_EQ(step(), first);
}

// Kernels made ahead, by another thread, are those that the pass would have made.
TEST(GuidedPasses, TakeUpKernelsMadeAhead) {
    GuidedBench ahead("box", {"painting.baseColor"}, 32), other("box", {"painting.baseColor"}, 32);
    GuidedPasses passes(*ahead.renderer, {});
    passes.prepareAhead({Renderer::Mode::Render, Renderer::Mode::Reverse});
    passes.prepareAhead({Renderer::Mode::Reverse}); // twice does no harm
    const Image image = passes.render(ahead.view, 4, {5, 0, 0});
    EXPECT_EQ(image.values, other.renderer->render(other.view, 4, {5, 0, 0}, other.plan, &other.result).values);
    EXPECT_EQ(ahead.gradient(4, {5, 0, 1}), other.gradient(4, {5, 0, 1}));
}

} // namespace
} // namespace cmpg::test

// Passes in parts: samples that continue a film, short submissions, passes that are ended early.
#include "render/guided_passes.h"
#include "support/guided_fixture.h"

#include <chrono>

namespace cmpg::test {
namespace {

constexpr int kEdge = 24;
constexpr PassKey kKey{.seed = 5, .step = 3, .pass = 0};

struct Stop {};

TEST(Progressive, PassesInPartsLeaveTheBitsOfOne) {
    for (const Sampler sampler : {Sampler::Sobol, Sampler::Independent}) {
        RenderConfig config;
        config.maxDepth = 5;
        config.sampler = sampler;
        Bench bench(bundledScene("materials"), {"*.baseColor"}, config);
        const View view = viewOf(bench.scene, kEdge, kEdge);
        Layers whole;
        const Image image = bench.renderer->render(view, 13, kKey, bench.plan, &bench.result, &whole);
        const Image gradient = bench.renderer->forward(view, 13, kKey, bench.config.differentiable, bench.ones(), bench.plan, &bench.result);
        Film film(kEdge, kEdge, true), derivative(kEdge, kEdge);
        for (const std::uint32_t spp : {1u, 4u, 2u, 6u}) {
            bench.renderer->render(view, spp, kKey, film, bench.plan);
            bench.renderer->forward(view, spp, kKey, bench.config.differentiable, bench.ones(), derivative, bench.plan);
        }
        EXPECT_EQ(film.samples, 13u);
        EXPECT_EQ(film.image().values, image.values);
        EXPECT_EQ(derivative.image().values, gradient.values);
        const Layers layers = film.layers();
        EXPECT_EQ(layers.albedo.values, whole.albedo.values);
        EXPECT_EQ(layers.depth.values, whole.depth.values);
        EXPECT_EQ(layers.cell.values, whole.cell.values);
    }
}

TEST(Progressive, ShortSubmissionsChangeNothing) {
    GuidedBench bench("box", {"painting.baseColor"}, kEdge);
    const auto all = [&] {
        std::vector<Image> images{bench.renderer->render(bench.view, 40, kKey, bench.plan, &bench.result),
                                  bench.renderer->forward(bench.view, 40, kKey, bench.config.differentiable, bench.directions, bench.plan, &bench.result)};
        return std::pair(images, bench.gradient(40, kKey));
    };
    const auto [images, gradient] = all();
    std::uint32_t submissions = 0;
    bench.renderer->setInteraction({.submissionSeconds = 1e-6, .beforeSubmission = [&] { ++submissions; }, .compiling = {}});
    const auto [parts, sums] = all();
    EXPECT_GT(submissions, 100u); // 3 x 23 040 paths, 256 at a time once it is clear that none are quick enough
    for (std::size_t i = 0; i < images.size(); ++i)
        EXPECT_EQ(parts[i].values, images[i].values);
    EXPECT_EQ(sums, gradient);
}

TEST(Progressive, APassEndedEarlyLeavesNothing) {
    GuidedBench bench("box", {"painting.baseColor", "white.baseColor"}, kEdge);
    bench.train(2, 4);
    const auto everything = [&] {
        Film film(kEdge, kEdge);
        bench.plan = {.method = {Sampling::Conditional}};
        bench.renderer->render(bench.view, 8, kKey, film, bench.plan);
        std::vector<std::vector<double>> gradients;
        bench.plan = {.method = {Sampling::Conditional}, .record = true};
        bench.result = bench.renderer->reverse(bench.view, 8, kKey, bench.adjoint, {}, {}, gradients, bench.plan);
        const UpdateReport update = bench.renderer->updateGuide();
        return std::tuple(film.image().values, gradients, update.records);
    };
    const SdTree tree = bench.renderer->guide();
    const auto expected = everything();
    bench.renderer->setGuide(tree);

    std::uint32_t left = 0;
    bench.renderer->setInteraction({.submissionSeconds = 1e-6,
                                    .beforeSubmission =
                                        [&] {
                                            if (left-- == 0)
                                                throw Stop{};
                                        },
                                    .compiling = {}});
    Film film(kEdge, kEdge);
    std::vector<std::vector<double>> gradients;
    for (const std::uint32_t after : {0u, 1u, 3u, 9u}) {
        left = after;
        EXPECT_THROW(bench.renderer->render(bench.view, 8, kKey, film, bench.plan), Stop);
        EXPECT_EQ(film.samples, 0u);
        left = after;
        bench.plan = {.method = {Sampling::Conditional}, .record = true};
        EXPECT_THROW(bench.result = bench.renderer->reverse(bench.view, 8, kKey, bench.adjoint, {}, {}, gradients, bench.plan), Stop);
        EXPECT_TRUE(gradients.empty());
    }
    bench.renderer->discardRecords();
    bench.renderer->setInteraction({});
    EXPECT_EQ(everything(), expected);
}

TEST(Progressive, AnAbandonedStepCanBeginAgain) {
    const auto run = [](bool interrupt) {
        GuidedBench bench("box", {"painting.baseColor"}, kEdge);
        GuidedPasses passes(*bench.renderer, {});
        passes.setLearning(true);
        std::vector<std::vector<std::vector<double>>> all;
        for (std::uint32_t step = 0; step < 4; ++step) {
            const auto once = [&] {
                passes.render(bench.view, 4, {1, step, 0});
                std::vector<std::vector<double>> gradients;
                passes.reverse(bench.view, 4, {1, step, 1}, bench.adjoint, gradients);
                return gradients;
            };
            if (interrupt) {
                std::uint32_t left = 2 + step; // among the submissions of the derivative pass
                bench.renderer->setInteraction({.submissionSeconds = 0,
                                                .beforeSubmission =
                                                    [&] {
                                                        if (left-- == 0)
                                                            throw Stop{};
                                                    },
                                                .compiling = {}});
                try {
                    once();
                } catch (const Stop&) {
                }
                passes.abandonStep();
                bench.renderer->setInteraction({});
            }
            all.push_back(once());
            passes.endStep();
        }
        return all;
    };
    EXPECT_EQ(run(true), run(false));
}

TEST(Progressive, SubmissionsAreShort) {
    Bench bench(bundledScene("door"), {"painting.baseColor"});
    const View view = viewOf(bench.scene, 256, 192);
    bench.renderer->prepare({Renderer::Mode::Render, Renderer::Mode::Forward});
    std::vector<double> times;
    std::chrono::steady_clock::time_point last;
    constexpr double kTarget = 0.02;
    bench.renderer->setInteraction({.submissionSeconds = kTarget,
                                    .beforeSubmission =
                                        [&] {
                                            const auto now = std::chrono::steady_clock::now();
                                            times.push_back(std::chrono::duration<double>(now - last).count());
                                            last = now;
                                        },
                                    .compiling = {}});
    last = std::chrono::steady_clock::now();
    bench.renderer->render(view, 8, kKey, bench.plan, &bench.result);
    bench.renderer->forward(view, 8, kKey, bench.config.differentiable, bench.ones(), bench.plan, &bench.result);
    std::sort(times.begin(), times.end());
    RecordProperty("median_ms", int(1e3 * times[times.size() / 2]));
    RecordProperty("longest_ms", int(1e3 * times.back()));
    printf("%zu submissions, median %.1f ms, 90%% %.1f ms, longest %.1f ms\n", times.size(), 1e3 * times[times.size() / 2],
           1e3 * times[times.size() * 9 / 10], 1e3 * times.back());
    // Host work between submissions included; ten times the target leaves room for a busy machine, and one batch of the pools takes longer.
    EXPECT_LT(times[times.size() / 2], 10 * kTarget);
    EXPECT_GT(times.size(), 4u);
}

} // namespace
} // namespace cmpg::test

// Whether stated errors are true ones: images and gradients of bundled scenes against references of many more samples.
#include "optimize/batch_parts.h"
#include "render/guided_passes.h"
#include "scene/scene_file.h"

#include <cmath>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

constexpr int kSeeds = 100, kEdge = 40;
constexpr std::uint32_t kBatches = 8;
constexpr std::uint64_t kReferenceSeed = 1u << 20;

using Estimate = std::function<BudgetedEstimate(std::uint64_t seed, const SampleBudget& budget)>;

// How many of the intervals of 100 seeds hold the distance to a reference with a hundredth of their squared error. 95 % of 100: fewer
// than 90 or more than 99 happen by chance in 3 % of all cases; the seeds are fixed.
void expectCalibrated(const Estimate& estimate, double target) {
    const BudgetedEstimate reference = estimate(kReferenceSeed, {.batches = kBatches, .samples = 1u << 16, .error = target / 10});
    ASSERT_EQ(reference.end, BudgetedEstimate::End::Error);
    int within = 0;
    double samples = 0;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const BudgetedEstimate found = estimate(seed, {.batches = kBatches, .samples = 1u << 16, .error = target});
        ASSERT_EQ(found.end, BudgetedEstimate::End::Error);
        double norm = 0, distance = 0;
        for (std::size_t i = 0; i < found.mean.size(); ++i) {
            norm += found.mean[i] * found.mean[i];
            distance += (found.mean[i] - reference.mean[i]) * (found.mean[i] - reference.mean[i]);
        }
        // What the reference's own error adds on average comes off.
        const double own = std::pow(reference.error.relative, 2);
        const double error = std::sqrt(std::max(0.0, distance / norm - own));
        within += error >= found.error.low && error <= found.error.high;
        samples += double(found.samples) / kSeeds;
    }
    testing::Test::RecordProperty("within", within);
    std::printf("%d of %d within, %.0f samples of a batch on average\n", within, kSeeds, samples);
    EXPECT_GE(within, 90);
    EXPECT_LE(within, 99);
}

struct Estimator {
    explicit Estimator(const std::string& name, const std::string& parameter = "") : scene(loadScene(CMPG_SOURCE_DIR "/scenes/" + name + "/scene.gltf")) {
        RenderConfig config;
        config.maxDepth = 5;
        for (std::uint32_t p = 0; p < scene.parameters.size(); ++p)
            if (scene.parameters[p].name == parameter)
                config.differentiable.push_back(p);
        renderer = std::make_unique<Renderer>(device, scene, config);
        passes = std::make_unique<GuidedPasses>(*renderer, GuidedOptions{.sampling = Sampling::Bsdf, .roulette = false});
        view.camera = &scene.cameras.front();
        view.width = view.height = kEdge;
    }

    Estimate image() {
        return [this](std::uint64_t seed, const SampleBudget& budget) {
            return spendBudget(budget, [&](const BatchPart& part) {
                return fromImage(passes->render(view, part.samples, partKey({.seed = seed}, part, kBatches, true)));
            });
        };
    }
    Estimate gradient(const Image& adjoint) {
        return [this, &adjoint](std::uint64_t seed, const SampleBudget& budget) {
            return spendBudget(budget, [&](const BatchPart& part) {
                std::vector<std::vector<double>> found;
                passes->reverse(view, part.samples, partKey({.seed = seed, .pass = 1}, part, kBatches, false), adjoint, found);
                return joined(found);
            });
        };
    }

    Device device{Device::Options{}};
    Scene scene;
    std::unique_ptr<Renderer> renderer;
    std::unique_ptr<GuidedPasses> passes;
    View view;
};

// More in some pixels than in others, so that samples go there.
Image adjoint() {
    Image image(kEdge, kEdge, 3);
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = i / 3 % 7 == 0 ? 1.f : 0.2f;
    return image;
}

TEST(BudgetCalibration, FullImage) { expectCalibrated(Estimator("box").image(), 0.05); }

// All light comes through a gap: errors of pixels are large, unlike and rare.
TEST(BudgetCalibration, FullImageOfHardLight) { expectCalibrated(Estimator("door").image(), 0.3); }

TEST(BudgetCalibration, FullGradient) {
    const Image weights = adjoint();
    expectCalibrated(Estimator("box", "painting.baseColor").gradient(weights), 0.2);
}

// Three numbers, whose errors go together.
TEST(BudgetCalibration, FullGradientOfAConstant) {
    const Image weights = adjoint();
    expectCalibrated(Estimator("box", "white.baseColor").gradient(weights), 0.02);
}

} // namespace
} // namespace cmpg

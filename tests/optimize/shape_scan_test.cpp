// Shapes of lobes are tried over their range: a loss with two minima by a roughness, and how sure a gain is.
#include "optimize/optimize.h"
#include "optimize/shape_scan.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <set>

namespace cmpg {
namespace {

constexpr int kEdge = 16;

// Two of three pixels turn with the roughness of their texel, so that the loss has a minimum at every turn; the others tell one from the other. One sample
// is off by `noise`. Views are alike.
class TurningModel final : public ImageModel {
  public:
    TurningModel(double turns, double noise, std::vector<float> values, std::size_t views)
        : turns_(turns), noise_(noise), views_(views), now_(values), second_(std::move(values)) {}
    std::size_t views() const override { return views_; }
    std::pair<int, int> size(std::size_t) const override { return {kEdge, kEdge}; }
    Image picture(std::size_t, std::uint32_t spp, const PassKey& key, bool) override { return image(spp, key, now_, noise_); }
    ImageHalves renderHalves(std::size_t view, std::uint32_t spp, const PassKey& key, bool difference, const SampleRanges&) override {
        if (spp == kScanSpp)
            scanned.push_back(view);
        ImageHalves halves;
        halves.samples = std::max(1u, spp / 2);
        for (std::uint32_t h = 0; h < 2; ++h) {
            const PassKey own{key.seed, key.step, key.pass + 5 * h, key.firstSample};
            halves.half[h].image = image(halves.samples, own, now_, noise_);
            if (!difference)
                continue;
            halves.half[h].difference = image(halves.samples, own, second_, noise_);
            for (std::size_t i = 0; i < halves.half[h].image.values.size(); ++i)
                halves.half[h].difference.values[i] = halves.half[h].image.values[i] - halves.half[h].difference.values[i];
        }
        return halves;
    }
    void setSecondValues(std::uint32_t, std::span<const float> values) override { second_.assign(values.begin(), values.end()); }
    std::uint64_t reverse(std::size_t, std::uint32_t, const PassKey&, const Image& adjoint, std::vector<std::vector<double>>& gradients) override {
        for (std::size_t i = 0; i < adjoint.values.size(); ++i) {
            const double v = now_[texel(i, now_)];
            gradients[0][texel(i, now_)] += double(adjoint.values[i]) * (turns(i) ? -0.4 * turns_ * std::sin(turns_ * v + phase(i)) : 0.2);
        }
        return 1;
    }
    std::uint64_t reverseHalves(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients,
                                std::vector<std::vector<double>>&) override {
        return reverse(view, spp, key, adjoint, gradients);
    }
    void setParameter(std::uint32_t, std::span<const float> values) override { now_.assign(values.begin(), values.end()); }
    Image truth(const std::vector<float>& values) const { return image(1, {}, values, 0); }
    const std::vector<float>& now() const { return now_; }

    static constexpr std::uint32_t kScanSpp = 2; // no other images have so many samples
    std::vector<std::size_t> scanned;            // the views of images of scans

  private:
    static std::size_t texel(std::size_t i, const std::vector<float>& values) { return i / 9 % values.size(); } // three pixels each
    static bool turns(std::size_t i) { return i / 3 % 3 != 0; }
    static double phase(std::size_t i) { return i / 3 % 3 == 1 ? 0 : 1.5; }
    Image image(std::uint32_t spp, const PassKey& key, const std::vector<float>& values, double noise) const {
        Image result(kEdge, kEdge, 3);
        std::mt19937_64 random(key.seed * 1000003 + key.step * 7919ull + key.pass + key.firstSample * 104729ull);
        std::normal_distribution<double> normal(0, 1);
        for (std::size_t i = 0; i < result.values.size(); ++i) {
            const double v = values[texel(i, values)], off = noise / std::sqrt(double(spp)) * normal(random);
            result.values[i] = float((turns(i) ? 0.5 + 0.4 * std::cos(turns_ * v + phase(i)) : 0.5 + 0.2 * v) + off);
        }
        return result;
    }
    double turns_, noise_;
    std::size_t views_;
    std::vector<float> now_, second_;
};

struct TurningRun {
    Scene scene;
    TurningModel model;
    Optimization optimization;

    TurningRun(double turns, double noise, float start, const std::vector<float>& truth, std::uint32_t steps, std::uint64_t seed, OptimizerKind kind, std::size_t views = 1)
        : scene(sceneOf(start, truth.size())), model(turns, noise, scene.parameters[0].values, views),
          optimization(model, scene, configOf(model.truth(truth), steps, seed, kind, views), {0}) {}

    static Scene sceneOf(float start, std::size_t texels) {
        Scene scene;
        Parameter& roughness = scene.parameters.emplace_back();
        roughness.name = "ball.roughness";
        roughness.kind = SlotKind::Roughness;
        roughness.channels = 1;
        roughness.textured = texels > 1;
        roughness.width = std::uint32_t(texels);
        roughness.values.assign(texels, start);
        return scene;
    }
    static OptimizeConfig configOf(const Image& target, std::uint32_t steps, std::uint64_t seed, OptimizerKind kind, std::size_t views) {
        OptimizeConfig config;
        config.steps = steps;
        config.seed = seed;
        config.sppDifference = 12;
        config.optimizer.kind = kind;
        config.targets.resize(views);
        for (Target& of : config.targets)
            of.image = target;
        return config;
    }
    const std::vector<float>& values() const { return scene.parameters[0].values; }
};

// The values after `steps` steps from `start`.
std::vector<float> recovered(double turns, double noise, float start, const std::vector<float>& truth, std::uint32_t steps, std::uint64_t seed,
                             OptimizerKind kind = OptimizerKind::Auto) {
    TurningRun run(turns, noise, start, truth, steps, seed, kind);
    for (std::uint32_t i = 0; i < steps; ++i)
        run.optimization.step();
    EXPECT_EQ(run.values(), run.model.now()); // the model has what the host has
    return run.values();
}

float recovered(double turns, double noise, float start, float truth, std::uint32_t steps, std::uint64_t seed, OptimizerKind kind = OptimizerKind::Auto) {
    return recovered(turns, noise, start, std::vector<float>{truth}, steps, seed, kind)[0];
}

constexpr double kTurns = 7; // from 0.3 a loss rises to 0.75 and falls to 1

TEST(ShapeScan, LeavesALocalMinimum) {
    EXPECT_NEAR(recovered(kTurns, 0.02, 0.85f, 0.3f, 4, 0), 1, 0.02); // before the first scan
    for (std::uint64_t seed = 0; seed < 5; ++seed)
        EXPECT_NEAR(recovered(kTurns, 0.02, 0.85f, 0.3f, 16, seed), 0.3, 0.02) << "seed " << seed;
    EXPECT_NEAR(recovered(kTurns, 0.02, 0.85f, 0.3f, 16, 0, OptimizerKind::Adam), 1, 0.1); // as it is
}

TEST(ShapeScan, BeginsAMapAnewWhereItIsNearer) {
    std::vector<float> truth(16);
    for (std::size_t i = 0; i < truth.size(); ++i)
        truth[i] = 0.25f + 0.1f * float(i % 2);
    for (const float v : recovered(kTurns, 0.02, 0.85f, truth, 4, 0))
        EXPECT_GT(v, 0.95f);
    const std::vector<float> values = recovered(kTurns, 0.02, 0.85f, truth, 40, 0);
    for (std::size_t i = 0; i < truth.size(); ++i)
        EXPECT_NEAR(values[i], truth[i], 0.02) << "texel " << i;
}

// Three views, one a step: what one finds likely all decide on, after each was seen four times.
TEST(ShapeScan, AsksAllViewsWhereOneFindsAGain) {
    const std::vector<float> truth(16, 0.3f);
    const auto scannedIn = [](TurningRun& run, std::uint32_t steps) {
        for (std::uint32_t i = 0; i < steps; ++i)
            run.optimization.step();
        return std::set<std::size_t>(run.model.scanned.begin(), run.model.scanned.end());
    };
    TurningRun far(kTurns, 0.02, 0.85f, truth, 60, 0, OptimizerKind::Auto, 3), near(kTurns, 0.02, 0.32f, truth, 60, 0, OptimizerKind::Auto, 3);
    EXPECT_TRUE(scannedIn(far, 11).empty());
    EXPECT_EQ(scannedIn(far, 1).size(), 3u);
    EXPECT_LT(far.values()[0], 0.6f) << "it has moved";
    EXPECT_EQ(scannedIn(near, 12).size(), 1u);
    scannedIn(far, 40);
    for (const float v : far.values())
        EXPECT_NEAR(v, 0.3f, 0.02f);
}

// As it was kept after the step that moved, or after the next.
TEST(ShapeScan, ARunThatGoesOnIsOneRun) {
    const std::vector<float> truth(4, 0.3f);
    const std::vector<float> whole = recovered(kTurns, 0.02, 0.85f, truth, 10, 0);
    for (const int kept : {4, 5}) {
        TurningRun first(kTurns, 0.02, 0.85f, truth, 10, 0, OptimizerKind::Auto), second(kTurns, 0.02, 0.85f, truth, 10, 0, OptimizerKind::Auto);
        for (int i = 0; i < kept; ++i)
            first.optimization.step();
        EXPECT_LT(first.values()[0], 0.6f) << "it has moved";
        second.optimization.restore(first.optimization.state(), {first.values()}, first.optimization.gradients());
        for (int i = kept; i < 10; ++i)
            second.optimization.step();
        EXPECT_EQ(second.values(), whole) << "after " << kept;
    }
}

TEST(ShapeScan, LeavesTheOnlyMinimumAlone) {
    for (std::uint64_t seed = 0; seed < 5; ++seed)
        EXPECT_NEAR(recovered(2, 0.3, 0.55f, 0.5f, 40, seed), 0.5, 0.1) << "seed " << seed;
}

// Of 200 gains of nothing, by noise alone, none is taken for sure, and their errors are as large as they are said to be.
TEST(ShapeScan, ErrorsAreThoseOfNoise) {
    TurningModel noisy(0, 0.3, {0.3f}, 1);
    Target target;
    target.image = noisy.truth({0.3f});
    const Image weight = lossCurvature(Loss::Mse, target.image);
    double squares = 0, largest = 0;
    for (std::uint32_t n = 0; n < 200; ++n) {
        const auto images = [&](std::uint32_t first) {
            return std::array{noisy.renderHalves(0, 2, {1, first, 0}, false, {}), noisy.renderHalves(0, 2, {1, first + 1, 0}, false, {})};
        };
        ShapeGain gain;
        gain.add(images(4 * n), images(4 * n + 2), target, weight);
        gain.endRound();
        squares += gain.mean() * gain.mean() / (gain.error() * gain.error()) / 200;
        largest = std::max(largest, std::abs(gain.mean()) / gain.error());
    }
    EXPECT_NEAR(squares, 1, 0.4); // four standard errors of the mean of 200 squares
    EXPECT_LT(largest, 4);
}

} // namespace
} // namespace cmpg

// Shapes of lobes are tried over their range: a loss with two minima by a roughness, and how sure a gain is.
#include "optimize/optimize.h"
#include "optimize/shape_scan.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace cmpg {
namespace {

constexpr int kEdge = 16;

// Half of the pixels turn with the roughness, so that the loss has a minimum at every turn; the others tell one from the other. One sample is off by `noise`.
class TurningModel final : public ImageModel {
  public:
    TurningModel(double turns, double noise) : turns_(turns), noise_(noise) {}
    std::size_t views() const override { return 1; }
    std::pair<int, int> size(std::size_t) const override { return {kEdge, kEdge}; }
    Image render(std::size_t, std::uint32_t spp, const PassKey& key) override { return image(spp, key, now); }
    ImageHalves renderHalves(std::size_t, std::uint32_t spp, const PassKey& key, bool difference, const SampleRanges&) override {
        ImageHalves halves;
        halves.samples = std::max(1u, spp / 2);
        for (std::uint32_t h = 0; h < 2; ++h) {
            const PassKey own{key.seed, key.step, key.pass + 5 * h, key.firstSample};
            halves.half[h].image = image(halves.samples, own, now);
            if (!difference)
                continue;
            halves.half[h].difference = image(halves.samples, own, second_);
            for (std::size_t i = 0; i < halves.half[h].image.values.size(); ++i)
                halves.half[h].difference.values[i] = halves.half[h].image.values[i] - halves.half[h].difference.values[i];
        }
        return halves;
    }
    void setSecondValues(std::uint32_t, std::span<const float> values) override { second_ = values[0]; }
    std::uint64_t reverse(std::size_t, std::uint32_t, const PassKey&, const Image& adjoint, std::vector<std::vector<double>>& gradients) override {
        for (std::size_t i = 0; i < adjoint.values.size(); ++i)
            gradients[0][0] += double(adjoint.values[i]) * (turns(i) ? -0.4 * turns_ * std::sin(turns_ * now + phase(i)) : 0.2);
        return 1;
    }
    std::uint64_t reverseHalves(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients,
                                std::vector<std::vector<double>>&) override {
        return reverse(view, spp, key, adjoint, gradients);
    }
    void setParameter(std::uint32_t, std::span<const float> values) override { now = values[0]; }
    Image truth(double value) const { return image(1, {}, value, 0); }

    double now = 0;

  private:
    static bool turns(std::size_t i) { return i / 3 % 2 == 0; }
    static double phase(std::size_t i) { return i / 3 % 4 == 0 ? 0 : 1.5; }
    Image image(std::uint32_t spp, const PassKey& key, double value) const { return image(spp, key, value, noise_); }
    Image image(std::uint32_t spp, const PassKey& key, double value, double noise) const {
        Image result(kEdge, kEdge, 3);
        std::mt19937_64 random(key.seed * 1000003 + key.step * 7919ull + key.pass + key.firstSample * 104729ull);
        std::normal_distribution<double> normal(0, noise / std::sqrt(double(spp)));
        for (std::size_t i = 0; i < result.values.size(); ++i)
            result.values[i] = float((turns(i) ? 0.5 + 0.4 * std::cos(turns_ * value + phase(i)) : 0.5 + 0.2 * value) + (noise > 0 ? normal(random) : 0));
        return result;
    }
    double turns_, noise_, second_ = 0;
};

Scene oneRoughness(float start) {
    Scene scene;
    Parameter& roughness = scene.parameters.emplace_back();
    roughness.name = "ball.roughness";
    roughness.kind = SlotKind::Roughness;
    roughness.channels = 1;
    roughness.values = {start};
    return scene;
}

float recovered(TurningModel model, float start, double truth, std::uint32_t steps, std::uint64_t seed, OptimizerKind kind = OptimizerKind::Auto) {
    Scene scene = oneRoughness(start);
    model.now = start;
    OptimizeConfig config;
    config.steps = steps;
    config.seed = seed;
    config.sppDifference = 12;
    config.optimizer.kind = kind;
    config.targets.emplace_back().image = model.truth(truth);
    Optimization optimization(model, scene, config, {0});
    for (std::uint32_t i = 0; i < steps; ++i)
        optimization.step();
    EXPECT_EQ(scene.parameters[0].values[0], float(model.now)); // the model has what the host has
    return scene.parameters[0].values[0];
}

TEST(ShapeScan, LeavesALocalMinimum) {
    constexpr double kTurns = 7; // from 0.3 a loss rises to 0.75 and falls to 1
    EXPECT_NEAR(recovered({kTurns, 0.02}, 0.85f, 0.3, 4, 0), 1, 0.02); // before the first scan
    for (std::uint64_t seed = 0; seed < 5; ++seed)
        EXPECT_NEAR(recovered({kTurns, 0.02}, 0.85f, 0.3, 16, seed), 0.3, 0.02) << "seed " << seed;
    EXPECT_NEAR(recovered({kTurns, 0.02}, 0.85f, 0.3, 16, 0, OptimizerKind::Adam), 1, 0.1); // as it is
}

TEST(ShapeScan, LeavesTheOnlyMinimumAlone) {
    for (std::uint64_t seed = 0; seed < 5; ++seed)
        EXPECT_NEAR(recovered({2, 0.3}, 0.55f, 0.5, 40, seed), 0.5, 0.1) << "seed " << seed;
}

// Of 200 gains of nothing, by noise alone, none is taken for sure, and their errors are as large as they are said to be.
TEST(ShapeScan, ErrorsAreThoseOfNoise) {
    const TurningModel still(0, 0);
    Target target;
    target.image = still.truth(0.3);
    const Image weight = lossCurvature(Loss::Mse, target.image);
    double squares = 0, largest = 0;
    for (std::uint32_t n = 0; n < 200; ++n) {
        TurningModel noisy(0, 0.3), other(0, 0.3);
        noisy.now = other.now = 0.3;
        const auto images = [&](TurningModel& model, std::uint32_t first) {
            return std::array{model.renderHalves(0, 2, {1, first, 0}, false, {}), model.renderHalves(0, 2, {1, first + 1, 0}, false, {})};
        };
        ShapeGain gain;
        gain.add(images(noisy, 4 * n), images(other, 4 * n + 2), target, weight);
        gain.endRound();
        squares += gain.mean() * gain.mean() / (gain.error() * gain.error()) / 200;
        largest = std::max(largest, std::abs(gain.mean()) / gain.error());
    }
    EXPECT_NEAR(squares, 1, 0.4); // four standard errors of the mean of 200 squares
    EXPECT_LT(largest, 4);
}

} // namespace
} // namespace cmpg

// Gradients that are sampled in parts: what they say of their noise.
#include "optimize/batched_model.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace cmpg::test {
namespace {

// A gradient of two entries and, of a sample, a standard deviation of `deviation` in each.
class NoisyModel final : public ImageModel {
  public:
    static constexpr double kTruth[] = {3, -1};

    std::size_t views() const override { return 1; }
    std::pair<int, int> size(std::size_t) const override { return {1, 1}; }
    Image picture(std::size_t, std::uint32_t, const PassKey&, bool) override { return Image(1, 1, 3); }
    ImageHalves renderHalves(std::size_t, std::uint32_t, const PassKey&, bool, const SampleRanges&) override { return {}; }
    void setSecondValues(std::uint32_t, std::span<const float>) override {}
    std::uint64_t reverse(std::size_t, std::uint32_t, const PassKey&, const Image&, std::vector<std::vector<double>>&) override {
        ADD_FAILURE() << "a part takes itself for the whole";
        return 0;
    }
    std::uint64_t reversePart(std::size_t, std::uint32_t spp, const PassKey&, const Image&, std::vector<std::vector<double>>& gradients) override {
        for (std::size_t i = 0; i < 2; ++i)
            gradients[0][i] += kTruth[i] + deviation * normal_(random_) / std::sqrt(double(spp));
        return spp;
    }
    std::uint64_t reverseHalves(std::size_t, std::uint32_t, const PassKey&, const Image&, std::vector<std::vector<double>>&,
                                std::vector<std::vector<double>>&) override {
        return 0;
    }
    void tellNoise(const std::vector<std::vector<double>>& half, const std::vector<std::vector<double>>& sum) override {
        ++told;
        noise += (half[0][0] * half[0][0] + half[0][1] * half[0][1]) / 2;
        toldOf = sum;
    }
    void setParameter(std::uint32_t, std::span<const float>) override {}

    int told = 0;
    double noise = 0, deviation = 1;
    std::vector<std::vector<double>> toldOf;

  private:
    std::mt19937 random_{3};
    std::normal_distribution<double> normal_;
};

// Whatever the number of batches, what they have in common is no noise.
TEST(BatchedModel, HasNoNoiseWhereBatchesAgree) {
    for (const std::uint32_t batches : {8u, 9u, 63u}) {
        NoisyModel inner;
        inner.deviation = 0;
        BatchedModel model(inner, {.batches = batches, .samples = 4});
        std::vector<std::vector<double>> gradients{{0, 0}}, half{{0, 0}};
        model.reverseHalves(0, 0, {}, Image(1, 1, 3), gradients, half);
        for (std::size_t i = 0; i < 2; ++i) {
            EXPECT_NEAR(gradients[0][i], NoisyModel::kTruth[i], 1e-6);
            EXPECT_NEAR(half[0][i], 0, 1e-12) << batches;
        }
    }
}

TEST(BatchedModel, TellsTheNoiseOfTheWholeGradientOnce) {
    constexpr int kGradients = 800;
    constexpr double kVariance = 1.0 / (8 * 16);
    NoisyModel inner;
    BatchedModel model(inner, {.batches = 8, .samples = 16, .error = 1e-9}); // which takes all samples
    double squares = 0;
    for (int n = 0; n < kGradients; ++n) {
        std::vector<std::vector<double>> gradients{{10, 0}}; // 10: of a view before
        model.reverse(0, 0, {}, Image(1, 1, 3), gradients);
        EXPECT_EQ(inner.toldOf, gradients);
        squares += std::pow(gradients[0][0] - 10 - NoisyModel::kTruth[0], 2) / kGradients;
    }
    EXPECT_EQ(inner.told, kGradients);
    // Squares of normal numbers: standard errors of 5 % and, of two entries, 3.5 %; four of them.
    EXPECT_NEAR(squares, kVariance, 0.2 * kVariance);
    EXPECT_NEAR(inner.noise / kGradients, kVariance, 0.14 * kVariance);
}

} // namespace
} // namespace cmpg::test

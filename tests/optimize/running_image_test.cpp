// The image that steps carry on: its mean is the image's, and its variance what its halves say.
#include "optimize/running_image.h"
#include "linear_model.h"

#include <gtest/gtest.h>

namespace cmpg::test {
namespace {

constexpr double kNoise = 0.3;
constexpr int kWidth = 16, kHeight = 16;

// Runs over a path of parameters that no image has a part in; returns the running image at its end.
RunningImage alongAPath(std::uint64_t seed, std::uint32_t steps, float stepSize, std::span<const std::uint32_t> counts = {}) {
    Scene scene = makeScene();
    LinearModel model(scene, 1, kWidth, kHeight, kNoise);
    RunningImage image;
    float change = 0;
    for (std::uint32_t step = 0; step < steps; ++step) {
        const PassKey key{seed, 0, 0, image.used};
        if (step == 0)
            image.begin(model.renderHalves(0, 8, key, true, {}));
        else
            image.advance(model.renderHalves(0, 2, key, true, {counts, image.samples}), {}, double(change) * change);
        if (step + 1 == steps)
            break;
        change = stepSize / float(step + 1);
        for (std::uint32_t p = 0; p < scene.parameters.size(); ++p) {
            std::vector<float>& values = scene.parameters[p].values;
            model.setSecondValues(p, values);
            for (std::size_t i = 0; i < values.size(); ++i)
                values[i] += (i % 2 == 0 ? 1 : -1) * change;
            model.setParameter(p, values);
        }
    }
    return image;
}

Image truthAfter(std::uint32_t steps, float stepSize) {
    Scene scene = makeScene();
    for (Parameter& p : scene.parameters)
        for (std::uint32_t step = 0; step + 1 < steps; ++step)
            for (std::size_t i = 0; i < p.values.size(); ++i)
                p.values[i] += (i % 2 == 0 ? 1 : -1) * stepSize / float(step + 1);
    return LinearModel(scene, 1, kWidth, kHeight, 0).picture(0, 1, {}, false);
}

// Of its mean, averaged over the entries.
double varianceOf(const RunningImage& image) {
    double sum = 0;
    for (std::size_t i = 0; i < image.half[0].values.size(); ++i)
        sum += std::pow(double(image.half[0].values[i]) - image.half[1].values[i], 2);
    return sum / (4 * double(image.half[0].values.size()));
}

// 64 runs of 768 values: the largest of 768 standardised means stays below 4.5 with a confidence of 99 %.
TEST(RunningImage, HasTheMeanOfTheImage) {
    constexpr std::uint32_t kSteps = 30, kRuns = 64;
    const Image truth = truthAfter(kSteps, 0.02f);
    std::vector<double> sum(truth.values.size()), squares(truth.values.size());
    double claimed = 0;
    for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
        const RunningImage image = alongAPath(seed, kSteps, 0.02f);
        const Image mean = image.mean();
        for (std::size_t i = 0; i < sum.size(); ++i) {
            const double error = double(mean.values[i]) - truth.values[i];
            sum[i] += error;
            squares[i] += error * error;
        }
        claimed += varianceOf(image) / kRuns;
    }
    double found = 0;
    for (std::size_t i = 0; i < sum.size(); ++i) {
        const double mean = sum[i] / kRuns, variance = squares[i] / kRuns - mean * mean;
        EXPECT_LT(std::abs(mean), 4.5 * std::sqrt(variance / (kRuns - 1)) + 1e-6) << "value " << i;
        found += squares[i] / kRuns / double(sum.size());
    }
    EXPECT_NEAR(claimed, found, 0.1 * found);
}

// Thirty steps of two samples after the first eight: noise below that of sixteen samples, which a step would have to render anew.
TEST(RunningImage, GathersTheSamplesOfManySteps) {
    const Image truth = truthAfter(30, 0.02f);
    LinearModel fresh(makeScene(), 1, kWidth, kHeight, kNoise);
    double squares = 0;
    for (std::uint64_t seed = 0; seed < 16; ++seed)
        squares += varianceOf(alongAPath(seed, 30, 0.02f)) / 16;
    double single = 0; // of one sample, from the model's own definition
    for (const float v : truth.values)
        single += double(v) * v * kNoise * kNoise / double(truth.values.size());
    EXPECT_LT(squares, single / 16);
    EXPECT_GT(squares, single / 68);
}

// A method with a hundredth of the variance takes over: two of its samples in a half weigh as much as they tell, beside 32 of the method before.
TEST(RunningImage, WeighsSamplesOfAnotherMethodByTheirVariance) {
    Scene scene = makeScene();
    LinearModel noisy(scene, 1, kWidth, kHeight, kNoise), clean(scene, 1, kWidth, kHeight, 0.1 * kNoise);
    for (LinearModel* model : {&noisy, &clean})
        for (std::uint32_t p = 0; p < scene.parameters.size(); ++p)
            model->setSecondValues(p, scene.parameters[p].values);
    double single = 0; // of one sample of the clean model
    for (const float v : truthAfter(1, 0).values)
        single += double(v) * v * 0.01 * kNoise * kNoise / (3.0 * kWidth * kHeight);
    constexpr double kRuns = 16, kWorth = 2 * (0.32 + 2); // of both halves, in clean samples
    double weighed = 0, alike = 0;
    for (std::uint64_t seed = 0; seed < 16; ++seed) {
        RunningImage image, other;
        image.begin(noisy.renderHalves(0, 64, {seed, 0, 0}, true, {}));
        other = image;
        image.changeMethod(Sampling::Primal, 0.01);
        EXPECT_EQ(image.method, Sampling::Primal);
        for (RunningImage* i : {&image, &other})
            i->advance(clean.renderHalves(0, 4, {seed, 1, 0}, true, {}), {}, 0);
        EXPECT_NEAR(image.worth[0], kWorth / 2, 1e-4);
        weighed += varianceOf(image) / kRuns;
        alike += varianceOf(other) / kRuns;
    }
    EXPECT_NEAR(weighed, single / kWorth, 0.1 * single / kWorth);
    EXPECT_GT(alike, 4 * weighed); // as it would be by counts alone
}

TEST(RunningImage, CountsTheSamplesOfEachPixel) {
    std::vector<std::uint32_t> counts(kWidth * kHeight, 1);
    counts[5] = 7;
    RunningImage image = alongAPath(1, 3, 0.02f, counts);
    EXPECT_EQ(image.samples[4], 4u + 2u);
    EXPECT_EQ(image.samples[5], 4u + 2u * 7u);
    EXPECT_EQ(image.used, image.samples[5]);
    image.drop();
    EXPECT_TRUE(image.samples.empty());
    EXPECT_EQ(image.used, 4u + 2u * 7u); // none of these is drawn again
}

TEST(RunningImage, StandsStillWithTheParameters) {
    const RunningImage image = alongAPath(1, 20, 0.0f);
    EXPECT_EQ(image.differences, 0u); // nothing is learned of differences from none
    EXPECT_EQ(image.used, 4u + 19u);
    EXPECT_EQ(image.samples, std::vector<std::uint32_t>(kWidth * kHeight, 4u + 19u));
    const Image truth = truthAfter(20, 0.0f);
    double single = 0;
    for (const float v : truth.values)
        single += double(v) * v * kNoise * kNoise / double(truth.values.size());
    EXPECT_NEAR(varianceOf(image), single / 46, 0.15 * single / 46); // as of all samples together
}

} // namespace
} // namespace cmpg::test

// What learning passes measure of the ways to sample, against the variance over many passes. Seeds are fixed.
#include "render/guided_passes.h"
#include "support/guided_fixture.h"

namespace cmpg::test {
namespace {

constexpr std::uint32_t kSpp = 16;

// Of a reverse pass, summed over the texels, from passes with numbers of their own.
double varianceOverSeeds(GuidedBench& s, std::uint32_t passes, std::uint32_t spp = kSpp) {
    std::vector<double> sum, squares;
    for (std::uint32_t i = 0; i < passes; ++i) {
        const std::vector<double> g = s.gradient(spp, {900 + i, 0, 1})[0];
        sum.resize(g.size());
        squares.resize(g.size());
        for (std::size_t k = 0; k < g.size(); ++k) {
            sum[k] += g[k];
            squares[k] += g[k] * g[k];
        }
    }
    double variance = 0;
    for (std::size_t k = 0; k < sum.size(); ++k)
        variance += (squares[k] - sum[k] * sum[k] / passes) / (passes - 1);
    return variance;
}

// Sobol points do far better in the box than samples that are independent within a pixel, which is what moments of paths tell. The figures
// that decide must know.
TEST(SamplingFigures, OfLearningPassesSeeWhatSobolPointsGain) {
    GuidedBench s("box", {"painting.baseColor"}, 32);
    GuidedPasses passes(*s.renderer, {.sampling = Sampling::Bsdf, .pixels = PixelSampling::Uniform});
    passes.trainReverse(s.view, kSpp, 4, 5, s.adjoint);
    const SamplingDecision decision = passes.decision();
    double squares = 0;
    for (const float a : s.adjoint.values)
        squares += double(a) * a;
    s.plan = {.measure = true};
    s.gradient(kSpp, {899, 0, 1});
    const double moments = s.result.variance;
    s.plan = {};
    const double truth = varianceOverSeeds(s, 24), figure = decision.figures.at(Sampling::Bsdf).variance * squares / kSpp;
    // Three pairs of four passes, the latest counting half: a relative standard error of 0.2 at 64 entries that share the differences.
    EXPECT_NEAR(figure, truth, 0.6 * truth);
    EXPECT_GT(moments, 2 * truth);
    // With roulette: the ratio of one pair of passes each, with standard errors below a third; a factor of two either way.
    s.plan = {.record = true};
    s.gradient(kSpp, {898, 0, 1});
    s.plan = {.method = {.roulette = true}, .reference = s.result.reference};
    const double ratio = varianceOverSeeds(s, 24) / truth;
    const double measured = decision.rouletteFigures.at(Sampling::Bsdf).variance / decision.figures.at(Sampling::Bsdf).variance;
    EXPECT_NEAR(std::log2(measured / ratio), 0, 1);
}

// Steps of an optimisation know it, too, from passes in two halves.
TEST(SamplingFigures, OfOptimisationsSeeWhatSobolPointsGain) {
    GuidedBench s("box", {"painting.baseColor"}, 32);
    GuidedPasses passes(*s.renderer, {.sampling = Sampling::Bsdf, .pixels = PixelSampling::Uniform, .immediate = true});
    passes.setLearning(true);
    std::vector<std::vector<double>> halved;
    const std::uint64_t paths = passes.reverse(s.view, kSpp, {5, 0, 1}, s.adjoint, halved);
    passes.endStep();
    double squares = 0;
    for (const float a : s.adjoint.values)
        squares += double(a) * a;
    const double truth = varianceOverSeeds(s, 24, kSpp / 2), figure = passes.decision().figures.at(Sampling::Bsdf).variance * squares / (kSpp / 2);
    EXPECT_NEAR(figure, truth, 0.6 * truth); // one pair, its relative standard error below a third
    // The mean of both: as many paths, and an unbiased estimate.
    EXPECT_EQ(paths, kSpp * 32u * 32);
    double along = 0;
    constexpr int kPasses = 16;
    for (std::uint32_t i = 0; i < kPasses; ++i)
        along += s.along(s.gradient(kSpp, {300 + i, 0, 1}), 0) / kPasses;
    EXPECT_NEAR(s.along(halved, 0), along, 0.03 * along);
}

} // namespace
} // namespace cmpg::test

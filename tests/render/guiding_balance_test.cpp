// How light and derivatives share the mixture along a path, and what that buys. Seeds are fixed.
#include "support/guided_fixture.h"

namespace cmpg::test {
namespace {

const PassKey kKey{5, 0, 1};

// Share of light in the mixture at a vertex of paths, 0 the camera's, over all directions drawn where the guide knew something.
double lightShare(const GuidedBench& s, std::size_t vertex) {
    const GuidedDepth& d = s.renderer->statistics().guided.at(vertex);
    EXPECT_GT(d.drawn, 1000u);
    return d.lightShare / double(d.drawn);
}

// The camera sees nothing but the painting, which paths meet once: with three segments nothing comes back to it, and no cell that the
// second vertices lie in knows a derivative. One segment more is a way back.
TEST(GuideWeights, LightAloneWhereNoWayLeadsBack) {
    double shares[2][2] = {};
    for (const std::uint32_t depth : {3u, 4u}) {
        GuidedBench s("box", {"painting.baseColor"}, 24, guidedConfig(depth));
        Camera close;
        close.toWorld[3] = {0, 1.24f, 0, 1};
        close.yfov = 0.6f; // +-0.3 of the painting's +-0.56, 0.945 away
        s.view.camera = &close;
        s.train(4, 64);
        s.renderer->setSampling({.kind = Sampling::Conditional});
        s.gradient(16, kKey);
        for (const std::size_t vertex : {0u, 1u})
            shares[depth - 3][vertex] = lightShare(s, vertex);
    }
    EXPECT_EQ(shares[0][0], 0); // no parameter has been met yet
    EXPECT_EQ(shares[1][0], 0);
    EXPECT_GT(shares[0][1], 0.99); // a cell at the painting's edge may hold a wall too
    EXPECT_LT(shares[1][1], 0.95);
}

// A nearly black patch beside a bright wall, seen by way of other surfaces: with one guide and equal samples the conditional mixture has
// less variance than either of its parts. Derivatives alone come close: some 15 million paths a kind tell 10 % apart.
TEST(GuideBalance, FullMixtureBeatsItsParts) {
    RenderConfig config = guidedConfig(6);
    config.guide.cellRecords = 16000;
    GuidedBench s("occluded", {"patch.baseColor"}, 96, config);
    for (std::uint32_t i = 0; i < 6; ++i) {
        s.renderer->setSampling({.kind = Sampling::Conditional, .record = true});
        s.gradient(16, {77, i, 3});
        s.renderer->updateGuide();
    }
    const auto variance = [&](Sampling kind, std::uint32_t passes) { // of the gradient of a pass, summed over the texels
        std::vector<double> found;
        s.renderer->setSampling({.kind = kind, .measure = true});
        for (std::uint32_t i = 0; i < passes; ++i) {
            s.gradient(16, {100 + i, 0, 1});
            found.push_back(s.renderer->lastPass().variance);
        }
        return statistics(found);
    };
    const MeanError mixture = variance(Sampling::Conditional, 100);
    for (const auto& [kind, passes, what] : {std::tuple(Sampling::Primal, 10u, "light alone"), {Sampling::Differential, 100u, "derivatives alone"}}) {
        const MeanError part = variance(kind, passes);
        // Three joint standard errors: confidence 99.9 %.
        EXPECT_GT(part.mean - mixture.mean, 3 * std::hypot(part.standardError, mixture.standardError))
            << what << ": " << part.mean << " +- " << part.standardError << ", mixture: " << mixture.mean << " +- " << mixture.standardError;
    }
}

} // namespace
} // namespace cmpg::test

// How light and derivatives share the mixture along a path, what that buys, and the layers that show it. Seeds are fixed.
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
        s.plan = {.method = {Sampling::Conditional}};
        s.gradient(16, kKey);
        for (const std::size_t vertex : {0u, 1u})
            shares[depth - 3][vertex] = lightShare(s, vertex);
    }
    EXPECT_NEAR(shares[0][0], 0.25, 0.5 / 255); // no parameter has been met yet: what is kept for light in any case, in the counts' unit
    EXPECT_NEAR(shares[1][0], 0.25, 0.5 / 255);
    EXPECT_GT(shares[0][1], 0.99); // a cell at the painting's edge may hold a wall too
    EXPECT_LT(shares[1][1], 0.95);
}

// A nearly black patch beside a bright wall, seen by way of other surfaces: with one guide and equal samples the conditional mixture has
// less variance than either of its parts. Derivatives alone come close: some 40 million paths of theirs tell 9 % apart.
TEST(GuideBalance, FullMixtureBeatsItsParts) {
    RenderConfig config = guidedConfig(6);
    config.guide.cellRecords = 16000;
    GuidedBench s("occluded", {"patch.baseColor"}, 96, config);
    for (std::uint32_t i = 0; i < 6; ++i) {
        s.plan = {.method = {Sampling::Conditional}, .record = true};
        s.gradient(16, {77, i, 3});
        s.renderer->updateGuide();
    }
    const auto variance = [&](Sampling kind, std::uint32_t passes) { // of the gradient of a pass, summed over the texels
        std::vector<double> found;
        s.plan = {.method = {kind}, .measure = true};
        for (std::uint32_t i = 0; i < passes; ++i) {
            s.gradient(16, {100 + i, 0, 1});
            found.push_back(s.result.variance);
        }
        return statistics(found);
    };
    const MeanError mixture = variance(Sampling::Conditional, 100);
    for (const auto& [kind, passes, what] : {std::tuple(Sampling::Primal, 10u, "light alone"), {Sampling::Differential, 300u, "derivatives alone"}}) {
        const MeanError part = variance(kind, passes);
        // Three joint standard errors: confidence 99.9 %.
        EXPECT_GT(part.mean - mixture.mean, 3 * std::hypot(part.standardError, mixture.standardError))
            << what << ": " << part.mean << " +- " << part.standardError << ", mixture: " << mixture.mean << " +- " << mixture.standardError;
    }
}

// Layers of a derivative image: what they say is what the counts by depth say, and they change nothing.
TEST(GuideLayers, ShowTheBalanceByDepth) {
    GuidedBench s("furnace", {"*.baseColor"}, 16); // closed: every sample draws at every depth
    s.train(3, 16);
    s.plan = {.method = {Sampling::Conditional}};
    const Image plain = s.renderer->forward(s.view, 8, kKey, s.config.differentiable, s.ones(), s.plan, &s.result);
    const std::vector<GuidedDepth> before = s.renderer->statistics().guided;
    Layers layers;
    const Image image = s.renderer->forward(s.view, 8, kKey, s.config.differentiable, s.ones(), s.plan, &s.result, &layers);
    EXPECT_EQ(image.values, plain.values);
    ASSERT_EQ(layers.lightShare.size(), 4u); // of five segments the last draws nothing
    for (std::size_t d = 0; d < 4; ++d) {
        const GuidedDepth& all = s.renderer->statistics().guided[d];
        const double share = (all.lightShare - before[d].lightShare) / double(all.drawn - before[d].drawn);
        EXPECT_NEAR(meanOf(layers.lightShare[d]), share, 0.5 / 255) << d; // the counts' unit
        if (d == 0)
            EXPECT_NEAR(share, 0.25, 0.5 / 255);
        else
            EXPECT_GT(share, 0.3) << d;
    }
    // An image is drawn by light alone; without anything learned nothing is drawn at all.
    s.renderer->render(s.view, 8, kKey, s.plan, &s.result, &layers);
    for (const Image& share : layers.lightShare)
        for (const float of : share.values)
            EXPECT_FLOAT_EQ(of, 1.0f); // a quotient of equals, which Vulkan lets be off by 2.5 units in the last place
    GuidedBench empty("furnace", {"*.baseColor"}, 16, guidedConfig(2));
    empty.plan = {.method = {Sampling::Conditional}};
    empty.renderer->forward(empty.view, 8, kKey, empty.config.differentiable, empty.ones(), empty.plan, &empty.result, &layers);
    ASSERT_EQ(layers.lightShare.size(), 1u);
    EXPECT_EQ(layers.lightShare[0].values, std::vector<float>(16 * 16, -1.0f));
}

} // namespace
} // namespace cmpg::test

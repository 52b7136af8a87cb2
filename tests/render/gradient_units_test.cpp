// Gradients far smaller than the integer sums' unit was made for.
#include "guiding/samples.h"
#include "support/render_fixture.h"

#include <numeric>

namespace cmpg::test {
namespace {

const PassKey kKey{3, 0, 1};

// The painting, seen directly, in light that comes to it directly: other pixels do not depend on it.
struct Painting : Bench {
    View view;
    Image forward; // along ones

    static RenderConfig twoSegments(std::uint64_t budget, bool guiding) {
        RenderConfig config;
        config.maxDepth = 2;
        config.memoryBudget = budget;
        config.guiding = guiding;
        return config;
    }
    explicit Painting(std::uint64_t budget = std::uint64_t(1) << 30, bool guiding = false)
        : Bench(bundledScene("box"), {"painting.baseColor"}, twoSegments(budget, guiding)), view(viewOf(scene, 32, 32)),
          forward(renderer->forward(view, 8, kKey, config.differentiable, ones())) {}

    // 1 where the derivative is none, `size` where there is one.
    Image adjoint(float size) const {
        Image a(view.width, view.height, 3);
        for (std::size_t i = 0; i < a.values.size(); ++i)
            a.values[i] = forward.values[i] == 0 ? 1 : size;
        return a;
    }
    std::vector<double> gradient(const Image& adjoint) {
        std::vector<std::vector<double>> g;
        result = renderer->reverse(view, 8, kKey, adjoint, {}, {}, g, plan);
        return g.at(0);
    }
};

// In the first unit: sums that are a few, contributions that vanish, some of them even with the next.
TEST(GradientUnits, TinyDerivativesAreAsExactAsOthers) {
    Painting s;
    const auto agrees = [&](float size) {
        const Image adjoint = s.adjoint(size);
        double forward = 0;
        for (std::size_t i = 0; i < adjoint.values.size(); ++i)
            forward += double(adjoint.values[i]) * s.forward.values[i];
        ASSERT_GT(forward, 0);
        const std::vector<double> g = s.gradient(adjoint);
        EXPECT_NEAR(std::accumulate(g.begin(), g.end(), 0.0), forward, 1e-4 * forward) << size;
    };
    agrees(1);
    EXPECT_EQ(s.renderer->statistics().repeatedPasses, 0u);
    agrees(1e-9f);
    EXPECT_EQ(s.renderer->statistics().repeatedPasses, 1u);
    agrees(1e-12f);
    EXPECT_EQ(s.renderer->statistics().repeatedPasses, 2u);
    agrees(1e-16f);
    EXPECT_EQ(s.renderer->statistics().repeatedPasses, 4u);
    agrees(1e-24f);
    EXPECT_EQ(s.renderer->statistics().repeatedPasses, 6u);
    EXPECT_EQ(s.renderer->statistics().dropped.at("scan_tape: saturated gradient"), 0u);
}

TEST(GradientUnits, NoHistoryNorBudgetShows) {
    Painting large, small(std::uint64_t(12) << 20);
    const Image ordinary = large.adjoint(1), tiny = large.adjoint(0x1p-42f);
    const std::vector<double> first = large.gradient(tiny);
    EXPECT_EQ(small.gradient(ordinary), large.gradient(ordinary));
    EXPECT_EQ(small.gradient(tiny), first);
    EXPECT_EQ(large.gradient(tiny), first);
    EXPECT_EQ(large.renderer->statistics().repeatedPasses, 2u);
    EXPECT_EQ(small.renderer->statistics().repeatedPasses, 1u);
}

// Records are of light and derivatives without the adjoint: one pass and a repeated one teach the same.
TEST(GradientUnits, RecordsAreLeftOnce) {
    Painting once(std::uint64_t(1) << 30, true), twice(std::uint64_t(1) << 30, true);
    const auto learn = [](Painting& s, float size) {
        s.plan = {.record = true};
        s.gradient(s.adjoint(size));
        s.renderer->updateGuide();
    };
    learn(once, 1);
    learn(twice, 1e-9f);
    EXPECT_EQ(once.renderer->statistics().repeatedPasses, 0u);
    EXPECT_EQ(twice.renderer->statistics().repeatedPasses, 1u);
    EXPECT_EQ(once.renderer->guide().updates(), 1u);
    EXPECT_TRUE(same(once.renderer->guide(), twice.renderer->guide()));
    EXPECT_EQ(once.result.paths, twice.result.paths);
}

TEST(GradientUnits, NothingContributedIsNotLookedForAgain) {
    Painting s;
    for (const double g : s.gradient(s.adjoint(0)))
        ASSERT_EQ(g, 0);
    EXPECT_EQ(s.renderer->statistics().repeatedPasses, 0u);
}

// Emission seen directly: every pixel's derivative is 1, and large ones cancel. A finer unit would not hold them.
TEST(GradientUnits, LargeContributionsThatCancel) {
    RenderConfig config;
    config.maxDepth = 1;
    Bench s(bundledScene("furnace"), {"wall.emission"}, config);
    Image adjoint(3, 1, 3);
    for (int c = 0; c < 3; ++c) {
        adjoint.values[c] = 1;
        adjoint.values[3 + c] = -1;
        adjoint.values[6 + c] = 1e-12f;
    }
    std::vector<std::vector<double>> g;
    s.result = s.renderer->reverse(viewOf(s.scene, 3, 1), 4, kKey, adjoint, {}, {}, g, s.plan);
    const double unit = 0x1p-46; // 2^-48 of a sum of a little over 2, as a power of two
    for (const double entry : g.at(0))
        EXPECT_NEAR(entry, 1e-12, 4 * unit / 2 + 1e-18); // half of one for each of the pixel's samples
    EXPECT_EQ(s.renderer->statistics().repeatedPasses, 2u); // with the finer unit, and with the first again
    EXPECT_EQ(s.renderer->statistics().dropped.at("scan_tape: saturated gradient"), 0u);
}

// What is not one of these cases is passed once, for every parameter alone.
void expectOnePass(const char* name) {
    const Scene scene = bundledScene(name);
    for (const Parameter& p : scene.parameters) {
        RenderConfig config;
        config.maxDepth = 4;
        config.allFeatures = true; // few kernels for all
        config.memoryBudget = std::uint64_t(16) << 20;
        Bench s(scene, {p.name}, config);
        std::vector<std::vector<double>> g;
        s.result = s.renderer->reverse(viewOf(s.scene, 32, 32), 4, kKey, Image(32, 32, 3, 1.0f), {}, {}, g, s.plan);
        EXPECT_EQ(s.renderer->statistics().repeatedPasses, 0u) << name << ", " << p.name;
    }
}

TEST(GradientUnits, OrdinaryOnesNeedNoSecondPass) { expectOnePass("box"); }

TEST(GradientUnits, FullOrdinaryOnesNeedNoSecondPass) {
    for (const char* name : {"door", "door_roughness", "bowl", "environment", "materials", "occluded", "furnace"})
        expectOnePass(name);
}

} // namespace
} // namespace cmpg::test

// What passes leave in the guide, against images and derivatives of the same samples; what weights and empty guides do to a pass.
#include "support/guided_fixture.h"

#include "guiding/samples.h"

namespace cmpg::test {
namespace {

const PassKey kKey{5, 0, 1};

// One recorded pass into an empty guide: the sums over its cells.
TreeTotals recorded(GuidedBench& s, std::uint32_t spp, UpdateReport& report, bool forward = false) {
    s.plan = {.record = true};
    if (forward)
        s.renderer->forward(s.view, spp, kKey, s.config.differentiable, s.ones(), s.plan, &s.result);
    else
        s.gradient(spp, kKey);
    report = s.renderer->updateGuide();
    EXPECT_EQ(s.renderer->guide().validate(), "");
    s.plan = {};
    return totals(s.renderer->guide());
}

// Every vertex but the last of a path leaves one record, whatever it is worth. In a closed room with no light sampling those are the
// rays of the same pass with one segment less.
TEST(GuideRecords, OneForEveryDrawnDirection) {
    for (const std::uint32_t depth : {2u, 5u}) {
        RenderConfig config = guidedConfig(depth), shorter = guidedConfig(depth - 1);
        config.lightSampling = shorter.lightSampling = false;
        GuidedBench s("furnace", {"*.baseColor"}, 16, config), t("furnace", {"*.baseColor"}, 16, shorter);
        UpdateReport report;
        const TreeTotals sums = recorded(s, 4, report);
        t.gradient(4, kKey);
        EXPECT_EQ(report.records, t.result.rays) << depth;
        EXPECT_EQ(sums.records, double(report.records));
    }
}

// Learning passes keep what earlier ones left, but for one after a change of values. Steps always fade it.
TEST(GuideRecords, FadeWhereValuesChanged) {
    GuidedBench s("box", {"painting.baseColor"}, 16);
    double expected = 0;
    const auto pass = [&](bool step, double kept) {
        s.plan = {.record = true};
        s.gradient(4, kKey);
        expected = kept * expected + double(s.renderer->updateGuide(step).records);
        EXPECT_NEAR(totals(s.renderer->guide()).records, expected, 1e-9 * expected);
    };
    pass(false, 1);
    pass(false, 1);
    const std::uint32_t painting = s.config.differentiable[0];
    s.renderer->setParameter(painting, std::vector<float>(s.scene.parameters[painting].entries(), 0.5f));
    pass(false, 0.9);
    pass(false, 1);
    pass(true, 0.9);
}

// Two segments: a camera path has one record, w E, and images of one and two segments differ by its mean. With light sampling that
// is what all vertices reflect, and the records' share of it is less.
TEST(GuideRecords, SumUpToTheImage) {
    for (const bool lightSampling : {false, true}) {
        RenderConfig config = guidedConfig(2), direct = guidedConfig(1);
        config.lightSampling = direct.lightSampling = lightSampling;
        GuidedBench s("box", {"*.baseColor"}, 24, config), t("box", {"*.baseColor"}, 24, direct);
        UpdateReport report;
        const TreeTotals sums = recorded(s, 16, report);
        const double paths = 24 * 24 * 16;
        const double reflected = paths * (meanOf(s.renderer->render(s.view, 16, kKey, s.plan, &s.result)) - meanOf(t.renderer->render(t.view, 16, kKey, t.plan, &t.result)));
        // Sums of floats; records are rounded to 2^-24 of a typical one.
        EXPECT_NEAR(sums.reflected, reflected, 1e-5 * reflected);
        if (lightSampling) {
            EXPECT_GT(sums.mass.primal, 0);
            EXPECT_LT(sums.mass.primal, 0.9 * reflected);
        } else {
            EXPECT_NEAR(sums.mass.primal, reflected, 1e-5 * reflected);
        }
        // Albedo: all terms are positive, and along ones their sum is the L1 norm.
        const double derivative = paths * meanOf(s.renderer->forward(s.view, 16, kKey, s.config.differentiable, s.ones(), s.plan, &s.result));
        EXPECT_NEAR(sums.derivative, derivative, 1e-5 * derivative);
        EXPECT_EQ(sums.mass.minus, 0);
        if (!lightSampling) {
            EXPECT_NEAR(sums.mass.plus, derivative, 1e-5 * derivative);
        }
    }
}

// Both modes leave the same; an image leaves the same P, where the parameters do not ask for lobes that it does without.
TEST(GuideRecords, AreTheSameInAllModes) {
    const auto records = [](int mode) {
        GuidedBench s("materials", {"*.baseColor", "*.emission"}, 16);
        UpdateReport report;
        if (mode < 2) {
            recorded(s, 8, report, mode == 1);
        } else {
            s.plan = {.record = true};
            s.renderer->render(s.view, 8, kKey, s.plan, &s.result);
            s.renderer->updateGuide();
        }
        return s.renderer->guide();
    };
    const TreeTotals reverse = totals(records(0)), forward = totals(records(1)), image = totals(records(2));
    EXPECT_EQ(reverse.records, forward.records);
    EXPECT_NEAR(reverse.mass.primal, forward.mass.primal, 1e-5 * forward.mass.primal);
    EXPECT_NEAR(reverse.mass.plus, forward.mass.plus, 1e-5 * forward.mass.plus);
    EXPECT_NEAR(reverse.mass.minus, forward.mass.minus, 1e-5 * forward.mass.minus);
    EXPECT_NEAR(reverse.derivative, forward.derivative, 1e-5 * forward.derivative);
    // Derivative modes follow paths of black throughput whose records are zero.
    EXPECT_NEAR(image.mass.primal, forward.mass.primal, 1e-5 * forward.mass.primal);
    EXPECT_EQ(image.mass.plus + image.mass.minus + image.derivative, 0);
}

// The halves of positivization meet all derivatives and record both signs of them.
TEST(GuideRecords, DoNotDependOnTheSign) {
    TreeTotals sums[3];
    for (const int sign : {-1, 0, 1}) {
        GuidedBench s("materials", {"*"}, 16);
        s.plan = {.record = true, .sign = sign};
        s.gradient(8, kKey);
        s.renderer->updateGuide();
        sums[sign + 1] = totals(s.renderer->guide());
    }
    for (const int i : {0, 2}) {
        EXPECT_EQ(sums[i].records, sums[1].records);
        EXPECT_NEAR(sums[i].mass.plus, sums[1].mass.plus, 1e-5 * sums[1].mass.plus) << i - 1;
        EXPECT_NEAR(sums[i].mass.minus, sums[1].mass.minus, 1e-5 * sums[1].mass.minus) << i - 1;
        EXPECT_NEAR(sums[i].derivative, sums[1].derivative, 1e-5 * sums[1].derivative) << i - 1;
    }
}

// Derivatives by roughness have both signs in one place: their absolute values are kept, where a sum over the parameters or along a
// checkerboard of signs would lose them.
TEST(GuideRecords, KeepTermsOfOppositeSigns) {
    const auto learn = [](bool checkerboard) {
        GuidedBench s("materials", {"varied.roughness"}, 16);
        std::vector<std::vector<float>> directions = s.ones();
        if (checkerboard) {
            const Parameter& p = s.scene.parameters[s.config.differentiable[0]];
            for (std::size_t i = 0; i < directions[0].size(); ++i)
                directions[0][i] = (i % p.width + i / p.width) % 2 ? 1.0f : -1.0f;
        }
        s.plan = {.record = true};
        const Image image = s.renderer->forward(s.view, 32, kKey, s.config.differentiable, directions, s.plan, &s.result);
        s.renderer->updateGuide();
        return std::pair(s.renderer->guide(), 16.0 * 16 * 32 * meanOf(image));
    };
    const auto [tree, along] = learn(false);
    const auto [alternating, alongAlternating] = learn(true);
    EXPECT_TRUE(same(tree, alternating)); // what is kept knows no direction
    double plus = 0, minus = 0, cancelled = 0;
    for (const GuideCell& cell : tree.cells()) {
        plus += cell.total().plus;
        minus += cell.total().minus;
        cancelled += std::abs(cell.total().plus - cell.total().minus);
    }
    EXPECT_GT(plus, 0.1 * minus);
    EXPECT_GT(minus, 0.1 * plus);
    EXPECT_LT(cancelled, 0.8 * (plus + minus));
    EXPECT_LT(std::abs(alongAlternating), 0.2 * (plus + minus));
}

SdTree withoutLight(SdTree tree) {
    for (GuideCell& cell : tree.cells())
        for (QuadNode& node : cell.nodes)
            for (GuideMass& mass : node.mass)
                mass.primal = 0;
    return tree;
}

// At the camera's vertex no parameter has been met: light has no weight of its own, and where none is known that would keep its quarter the
// mixture is that of derivatives alone, to the bit.
TEST(GuideWeights, FirstVertexLooksForDerivatives) {
    for (const std::uint32_t depth : {2u, 3u}) {
        GuidedBench s("materials", {"*.baseColor", "*.roughness"}, 16, guidedConfig(depth));
        s.train(2, 8);
        if (depth == 2)
            s.renderer->setGuide(withoutLight(s.renderer->guide()));
        s.plan = {.method = {Sampling::Conditional}};
        const auto conditional = s.gradient(8, kKey);
        s.plan = {.method = {Sampling::Differential}};
        const auto differential = s.gradient(8, kKey);
        s.plan = {.method = {Sampling::Primal}};
        EXPECT_NE(s.gradient(8, kKey), conditional);
        if (depth == 2)
            EXPECT_EQ(conditional, differential);
        else
            EXPECT_NE(conditional, differential);
    }
}

struct Pass {
    Image image, forward;
    std::vector<std::vector<double>> gradient;
};

Pass passes(GuidedBench& s, Sampling kind) {
    s.plan = {.method = {kind}};
    return {s.renderer->render(s.view, 8, kKey, s.plan, &s.result), s.renderer->forward(s.view, 8, kKey, s.config.differentiable, s.ones(), s.plan, &s.result), s.gradient(8, kKey)};
}

void expectSameBits(const Pass& a, const Pass& b, const std::string& what) {
    EXPECT_TRUE(a.image.values == b.image.values) << what << ": images differ";
    EXPECT_TRUE(a.forward.values == b.forward.values) << what << ": forward derivatives differ";
    EXPECT_TRUE(a.gradient == b.gradient) << what << ": gradients differ";
}

// A guide that knows nothing changes nothing: none learned yet, or learned that nothing comes from anywhere.
TEST(EmptyGuide, ChangesNoBit) {
    RenderConfig without = guidedConfig();
    without.guiding = false;
    GuidedBench plain("materials", {"*"}, 16, without), s("materials", {"*"}, 16);
    const Pass truth = passes(plain, Sampling::Bsdf);
    expectSameBits(truth, passes(s, Sampling::Bsdf), "with room for a guide");
    expectSameBits(truth, passes(s, Sampling::Conditional), "nothing learned");
    SdTree nothing = s.renderer->guide();
    std::vector<Sample> samples = randomSamples(nothing.lower(), nothing.upper(), 5000, 1);
    for (Sample& sample : samples)
        sample.mass = {};
    nothing.update(place(nothing, samples));
    ASSERT_FALSE(nothing.empty());
    s.renderer->setGuide(nothing);
    expectSameBits(truth, passes(s, Sampling::Conditional), "nothing to learn");
    // Recording does not disturb: it takes other kernels, which round otherwise.
    s.plan = {.record = true};
    const auto recorded = s.gradient(8, kKey);
    for (std::size_t i = 0; i < recorded.size(); ++i)
        for (std::size_t k = 0; k < recorded[i].size(); ++k)
            EXPECT_NEAR(recorded[i][k], truth.gradient[i][k], 1e-5 * (1 + std::abs(truth.gradient[i][k])));
}

} // namespace
} // namespace cmpg::test

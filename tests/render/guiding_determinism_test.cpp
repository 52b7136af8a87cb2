// A guided optimisation's bits do not depend on runs, memory budgets or the kernels' variant: trees, gradients and images.
#include "support/guided_fixture.h"

#include "base/error.h"
#include "guiding/field/guide_buffers.h"
#include "guiding/samples.h"

namespace cmpg::test {
namespace {

struct Learned {
    SdTree tree{{}, {}, {}};
    Image image;
    std::vector<std::vector<double>> gradient;
    std::vector<double> variances, references; // of the passes
    double copies = 0; // of a path at the fullest bounce of the last pass, at least: of its rays, but the camera's, half are light samples'
    std::uint64_t paths = 0;
};

// A few steps that draw from what the last ones left, with splits of paths.
Learned learn(std::uint64_t budget, Device& on = device(), double split = 1) {
    RenderConfig config = guidedConfig(6);
    config.memoryBudget = budget;
    GuidedBench s("materials", {"*.baseColor", "*.roughness"}, 40, config, on);
    Learned r;
    double reference = 0;
    for (std::uint32_t step = 0; step < 3; ++step) {
        s.plan = {.method = {Sampling::Primal}, .record = true};
        r.image = s.renderer->render(s.view, 4, {3, step, 0}, s.plan, &s.result);
        s.plan = {.method = {Sampling::Conditional, true}, .record = true, .reference = split * reference};
        r.gradient = s.gradient(4, {3, step, 1});
        const PassResult& m = s.result;
        r.variances.push_back(m.variance);
        r.references.push_back(m.reference);
        if (step == 0)
            reference = m.reference;
        r.copies = (double(m.rays) / double(m.paths) - 1) / 2 / (config.maxDepth - 1);
        r.paths = m.paths;
        s.renderer->updateGuide();
    }
    r.tree = s.renderer->guide();
    return r;
}

void expectSame(const Learned& a, const Learned& b, const std::string& what) {
    EXPECT_TRUE(same(a.tree, b.tree)) << what << ": trees differ";
    EXPECT_TRUE(a.gradient == b.gradient) << what << ": gradients differ";
    EXPECT_TRUE(a.image.values == b.image.values) << what << ": images differ";
    // Sums in the order of the paths, whatever the batches, but for rounding.
    for (std::size_t i = 0; i < a.variances.size(); ++i) {
        EXPECT_NEAR(a.variances[i], b.variances[i], 1e-12 * a.variances[i]) << what;
        EXPECT_NEAR(a.references[i], b.references[i], 1e-12 * a.references[i]) << what;
    }
}

constexpr std::uint64_t kMegabyte = std::uint64_t(1) << 20;

TEST(GuidedDeterminism, SameBitsForEveryBudgetAndRun) {
    const Learned large = learn(1024 * kMegabyte);
    ASSERT_GT(large.tree.cells().size(), 10u);
    expectSame(large, learn(1024 * kMegabyte), "another run");
    expectSame(large, learn(8 * kMegabyte), "a small budget");
}

// Nearly every path splits fourfold at every vertex: batches that filled half of the pools overflow, are void, and run again in halves.
TEST(GuidedDeterminism, SameBitsWhenCopiesOverflow) {
    const Learned large = learn(1024 * kMegabyte, device(), 1e-3), small = learn(8 * kMegabyte, device(), 1e-3);
    ASSERT_GT(large.copies, 2); // the first batch of a pass has room for two
    ASSERT_GT(large.paths, 6000u); // 8 MiB hold no more at once
    expectSame(large, small, "a small budget");
}

TEST(GuidedDeterminism, SameBitsOnPortableKernels) {
    Device::Options options;
    options.portable = true;
    Device portable(options);
    ASSERT_TRUE(portable.portable());
    expectSame(learn(1024 * kMegabyte), learn(1024 * kMegabyte, portable), "portable kernels");
}

// Published in pieces, as it was learned, or whole, as a run that goes on does it: the same bits. Cells that learn nothing are not published
// again, while their weights fade.
TEST(GuidedDeterminism, SameBitsForAGuideThatIsPublishedAnew) {
    const RenderConfig config = guidedConfig(2); // records where the camera looks alone
    GuidedBench s("box", {"painting.baseColor"}, 24, config);
    s.train(2, 16);
    const View whole = s.view;
    Camera close = *whole.camera; // sees little of the scene
    close.yfov *= 0.1f;
    s.view.camera = &close;
    s.plan = {.record = true};
    for (std::uint32_t i = 0; i < 7; ++i) {
        s.gradient(1, {3, i, 1});
        s.renderer->updateGuide();
    }
    s.view = whole;
    const SdTree tree = s.renderer->guide();
    std::size_t faded = 0;
    for (const GuideCell& cell : tree.cells())
        faded += cell.faded < 1;
    ASSERT_GT(faded, 5u);
    ASSERT_LT(faded, tree.cells().size());
    const auto gradient = [](GuidedBench& b) {
        b.plan = {.method = {Sampling::Conditional}, .record = true};
        auto g = b.gradient(8, {9, 0, 1});
        b.renderer->updateGuide();
        return g;
    };
    GuidedBench other("box", {"painting.baseColor"}, 24, config);
    other.renderer->setGuide(tree);
    EXPECT_TRUE(gradient(s) == gradient(other));
    EXPECT_TRUE(same(s.renderer->guide(), other.renderer->guide()));
}

// What is not ordered on the device may come out right for years: the validation layers look.
TEST(GuidedDeterminism, KernelsWaitForEachOther) {
    std::unique_ptr<Device> checked;
    try {
        checked = std::make_unique<Device>(Device::Options{.select = {}, .validation = true, .portable = false});
    } catch (const Error& e) {
        GTEST_SKIP() << e.what();
    }
    GuidedBench s("box", {"painting.baseColor"}, 8, guidedConfig(3), *checked);
    const double reference = s.train(1, 8);
    s.plan = {.method = {Sampling::Conditional, true}, .record = true, .sign = 1, .reference = reference};
    EXPECT_NO_THROW(s.gradient(2, {1, 0, 1}));
    EXPECT_NO_THROW(s.renderer->forward(s.view, 2, {1, 0, 1}, s.config.differentiable, s.directions, s.plan, &s.result));
    EXPECT_NO_THROW(s.renderer->updateGuide());
}

// A guide of more nodes than the renderer has room for, as a file may hold.
TEST(GuideMemory, TreesThatDoNotFit) {
    RenderConfig config = guidedConfig();
    GuidedBench large("box", {"painting.baseColor"}, 16, config);
    large.train(3, 32);
    ASSERT_GT(large.renderer->guide().nodes(), 1000u);
    config.guideMemory = 64 << 10;
    GuidedBench s("box", {"painting.baseColor"}, 16, config);
    s.train(1, 16);
    const std::uint64_t room = GuideBuffers::nodesWithin(config.guideMemory);
    EXPECT_LE(s.renderer->guide().nodes(), room);
    EXPECT_THROW(s.renderer->setGuide(large.renderer->guide()), Error);
    s.train(2, 16); // still usable
    EXPECT_LE(s.renderer->guide().nodes(), room);
    // The other way round it grows into what there is.
    large.renderer->setGuide(s.renderer->guide());
    EXPECT_EQ(large.renderer->guide().config().maxNodes, GuideBuffers::nodesWithin(large.config.guideMemory));
}

} // namespace
} // namespace cmpg::test

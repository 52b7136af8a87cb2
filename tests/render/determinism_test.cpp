// Results do not depend on how the work is cut: memory budgets (hence batches) and runs give the same bits.
#include "support/render_fixture.h"

namespace cmpg::test {
namespace {

struct Results {
    Image image, forward;
    std::vector<std::vector<double>> gradients;
};

Results run(std::uint64_t budget) {
    RenderConfig config;
    config.memoryBudget = budget;
    Bench s(bundledScene("materials"), {"*.baseColor", "*.roughness"}, config);
    const View view = viewOf(s.scene, 64, 48);
    Results r;
    r.image = s.renderer->render(view, 20, {3, 0, 0});
    r.forward = s.renderer->forward(view, 20, {3, 0, 1}, s.config.differentiable, s.ones());
    Image adjoint(view.width, view.height, 3, 0.5f);
    s.renderer->reverse(view, 20, {3, 0, 1}, adjoint, {}, {}, r.gradients);
    return r;
}

TEST(Determinism, SameBitsForEveryBudgetAndRun) {
    const Results large = run(std::uint64_t(1) << 30), again = run(std::uint64_t(1) << 30), small = run(std::uint64_t(12) << 20);
    EXPECT_EQ(large.image.values, again.image.values);
    EXPECT_EQ(large.gradients, again.gradients);
    EXPECT_EQ(large.image.values, small.image.values);
    EXPECT_EQ(large.forward.values, small.forward.values);
    EXPECT_EQ(large.gradients, small.gradients);
}

// More samples of one pixel than a batch may hold: the film goes on where the last batch stopped.
TEST(Determinism, ManySamplesPerPixel) {
    RenderConfig config;
    config.maxDepth = 2;
    Bench s(bundledScene("furnace"), {}, config);
    const View view = viewOf(s.scene, 2, 1);
    const Image image = s.renderer->render(view, 40000, {1, 0, 0});
    const Image few = s.renderer->render(view, 4000, {2, 0, 0});
    EXPECT_NEAR(meanOf(image), meanOf(few), 0.01 * meanOf(few)); // a lost or doubled batch would show as tens of percent
    EXPECT_EQ(s.renderer->statistics().paths, 2u * 44000u);
}

// Every buffer is allocated before the first pass.
TEST(Determinism, ResidentMemoryDoesNotGrow) {
    Bench s(bundledScene("box"), {"painting.baseColor"});
    const View view = viewOf(s.scene, 32, 32);
    s.renderer->prepare({Renderer::Mode::Render, Renderer::Mode::Reverse});
    const std::uint64_t before = device().memory().current;
    Image adjoint(32, 32, 3, 1.0f);
    std::vector<std::vector<double>> gradients;
    for (std::uint32_t i = 0; i < 20; ++i) {
        s.renderer->render(view, 4, {1, i, 0});
        s.renderer->reverse(view, 2, {1, i, 1}, adjoint, {}, {}, gradients);
    }
    EXPECT_EQ(device().memory().current, before);
}

} // namespace
} // namespace cmpg::test

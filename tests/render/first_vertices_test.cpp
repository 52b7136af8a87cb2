// Where camera rays met the scene first, as a derivative pass tells it.
#include "render/first_vertices.h"
#include "support/render_fixture.h"
#include "support/scene_builder.h"

namespace cmpg::test {
namespace {

// A wall that fills the left half of the picture, before nothing.
Scene halfWall() {
    SceneBuilder b;
    const std::uint32_t wall = b.material("wall", 0.5f, 1);
    b.quad(wall, {-1, -1, 0}, {1, 0, 0}, {0, 2, 0});
    b.camera(1);
    return b.scene;
}

TEST(FirstVertices, AreThoseOfEachPixel) {
    constexpr int kSize = 16;
    FirstVertices whole;
    for (const std::uint64_t budget : {std::uint64_t(1) << 30, std::uint64_t(8) << 20}) {
        RenderConfig config;
        config.memoryBudget = budget;
        Bench b(halfWall(), {"wall.baseColor"}, config);
        const View view = viewOf(b.scene, kSize, kSize);
        Image adjoint(kSize, kSize, 3);
        std::fill(adjoint.values.begin(), adjoint.values.end(), 1.f);
        std::vector<std::uint32_t> counts(kSize * kSize);
        std::vector<float> weights(counts.size(), 1.f);
        for (std::size_t p = 0; p < counts.size(); ++p)
            counts[p] = std::uint32_t(p % 5 == 0 ? 0 : 40 * (p % 3));
        std::vector<std::vector<double>> gradients(1, std::vector<double>(b.scene.parameters[b.config.differentiable[0]].entries()));
        FirstVertices first;
        b.renderer->reverse(view, 4, {3, 0, 1}, adjoint, counts, weights, gradients, {}, &first);
        ASSERT_EQ(first.begin.size(), counts.size() + 1);
        ASSERT_EQ(first.vertices.size(), first.begin.back());
        for (std::size_t p = 0; p < counts.size(); ++p) {
            ASSERT_EQ(first.begin[p + 1] - first.begin[p], counts[p]);
            for (std::size_t i = first.begin[p]; i < first.begin[p + 1]; ++i)
                EXPECT_EQ(first.vertices[i].material, p % kSize < kSize / 2 ? 0 : kNoMaterial) << p;
        }
        if (whole.vertices.empty()) {
            whole = first;
            continue;
        }
        for (std::size_t i = 0; i < first.vertices.size(); ++i) { // whatever the batches
            EXPECT_EQ(first.vertices[i].material, whole.vertices[i].material);
            EXPECT_EQ(first.vertices[i].uv0, whole.vertices[i].uv0);
        }
    }
}

} // namespace
} // namespace cmpg::test

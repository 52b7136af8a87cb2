// Where camera rays met the scene first, as a derivative pass tells it.
#include "render/first_vertices.h"
#include "support/render_fixture.h"
#include "support/scene_builder.h"

namespace cmpg::test {
namespace {

constexpr int kSize = 16;

// A wall with a texture that fills the left half of the picture, before nothing. Texture coordinates grow to the right and up.
Scene halfWall() {
    SceneBuilder b;
    const std::uint32_t wall = b.material("wall", 0.5f, 1);
    b.quad(wall, {-1, -1, 0}, {1, 0, 0}, {0, 2, 0});
    b.camera(1);
    Parameter& colour = b.scene.parameters[b.scene.materials[wall].parameters[std::size_t(SlotKind::BaseColor)]];
    colour.width = 2;
    colour.textured = true;
    colour.values.resize(colour.entries(), 0.5f);
    return b.scene;
}

// In one batch; in batches that end within a pixel; by the kernels of a roulette, which give rays other places.
TEST(FirstVertices, AreThoseOfEachPixel) {
    std::vector<std::uint32_t> counts(kSize * kSize);
    for (std::size_t p = 0; p < counts.size(); ++p)
        counts[p] = std::uint32_t(p % 5 == 0 ? 0 : 40 * (p % 3));
    const std::vector<float> weights(counts.size(), 1.f);
    Image adjoint(kSize, kSize, 3);
    std::fill(adjoint.values.begin(), adjoint.values.end(), 1.f);
    FirstVertices whole;
    for (const auto& [megabytes, roulette] : {std::pair{1024u, false}, {8u, false}, {1024u, true}}) {
        RenderConfig config;
        config.memoryBudget = std::uint64_t(megabytes) << 20;
        config.guiding = config.roulette = roulette;
        Bench b(halfWall(), {"wall.baseColor"}, config);
        std::vector<std::vector<double>> gradients(1, std::vector<double>(6));
        FirstVertices first;
        PassPlan plan;
        plan.rouletteKernels = roulette;
        b.renderer->reverse(viewOf(b.scene, kSize, kSize), 4, {3, 0, 1}, adjoint, counts, weights, gradients, plan, &first);
        ASSERT_EQ(first.begin.size(), counts.size() + 1);
        ASSERT_EQ(first.vertices.size(), first.begin.back());
        for (std::size_t p = 0; p < counts.size(); ++p) {
            ASSERT_EQ(first.begin[p + 1] - first.begin[p], counts[p]);
            const float x = float(p % kSize), y = float(kSize - p / kSize);
            for (std::size_t i = first.begin[p]; i < first.begin[p + 1]; ++i) {
                const FirstVertex& found = first.vertices[i];
                EXPECT_EQ(found.material, x < kSize / 2 ? 0 : kNoMaterial) << p;
                if (found.material == kNoMaterial)
                    continue;
                constexpr float kRounding = 1e-5f;
                EXPECT_NEAR(found.uv0.x * kSize / 2, x + 0.5f, 0.5f + kRounding) << p;
                EXPECT_NEAR(found.uv0.y * kSize, y - 0.5f, 0.5f + kRounding) << p;
            }
        }
        if (whole.vertices.empty())
            whole = first;
        for (std::size_t i = 0; i < first.vertices.size(); ++i) { // sample by sample
            EXPECT_EQ(first.vertices[i].material, whole.vertices[i].material) << i;
            if (first.vertices[i].material != kNoMaterial) {
                EXPECT_EQ(first.vertices[i].uv0, whole.vertices[i].uv0) << i;
            }
        }
    }
}

} // namespace
} // namespace cmpg::test

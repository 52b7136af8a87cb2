// Reconstruction filters: an edge as each filter shows it, and derivatives through it. Seeds are fixed; 4 standard errors.
#include "support/render_fixture.h"
#include "support/scene_builder.h"

#include <numeric>

namespace cmpg::test {
namespace {

constexpr int kEdge = 8; // pixels

// A lamp on the left, up to 0.3 of a pixel into the fourth column.
Scene halfLit(const PixelFilter& filter) {
    SceneBuilder b;
    const std::uint32_t lamp = b.material("lamp", 0, 3);
    const float width = 2 * 3.3f / kEdge;
    b.quad(lamp, {-1, -1, 0}, {width, 0, 0}, {0, 2, 0});
    b.camera(1);
    b.scene.cameras[0].filter = filter;
    return b.scene;
}

double weight(const PixelFilter& f, double x) {
    const double r = double(f.radius), s = double(f.deviation);
    switch (f.kind) {
    case PixelFilter::Kind::Tent: return std::max(0.0, 1 - std::abs(x) / r);
    case PixelFilter::Kind::Gaussian: return std::max(0.0, std::exp(-x * x / (2 * s * s)) - std::exp(-r * r / (2 * s * s)));
    default: return std::abs(x) < r ? 1 : 0;
    }
}

// Of what the pixel weighs within the picture, the share left of the edge.
double shareLeft(const PixelFilter& f, int column) {
    constexpr int kSteps = 20000;
    double left = 0, all = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double x = kEdge * (i + 0.5) / kSteps, w = weight(f, x - (column + 0.5));
        all += w;
        left += x < 3.3 ? w : 0;
    }
    return left / all;
}

class PixelFilters : public testing::TestWithParam<PixelFilter> {};

TEST_P(PixelFilters, EdgesAreAsWideAsTheFilter) {
    Bench b(halfLit(GetParam()), {"lamp.emission"});
    const View view = viewOf(b.scene, kEdge, kEdge);
    std::array<std::vector<double>, kEdge> columns, derivatives;
    for (std::uint32_t pass = 0; pass < 8; ++pass) {
        const Image image = b.renderer->render(view, 256, {pass, 0, 0}), forward = b.renderer->forward(view, 256, {pass, 0, 1}, b.config.differentiable, b.ones());
        for (int x = 0; x < kEdge; ++x) {
            double sum = 0, derivative = 0;
            for (int y = 0; y < kEdge; ++y) {
                sum += image.values[3 * std::size_t(y * kEdge + x)] / kEdge;
                derivative += forward.values[3 * std::size_t(y * kEdge + x)] / kEdge;
            }
            columns[std::size_t(x)].push_back(sum);
            derivatives[std::size_t(x)].push_back(derivative);
        }
    }
    for (int x = 0; x < kEdge; ++x) {
        const double expected = shareLeft(GetParam(), x);
        const MeanError image = statistics(columns[std::size_t(x)]), derivative = statistics(derivatives[std::size_t(x)]);
        EXPECT_NEAR(image.mean, 3 * expected, 4 * image.standardError + 3e-4) << x;
        EXPECT_NEAR(derivative.mean, expected, 4 * derivative.standardError + 1e-4) << x;
        EXPECT_LT(image.standardError, 0.01) << x;
    }
}

// Every sample belongs to one pixel: the reverse derivative of a pixel is what the forward one says of it, not of its neighbours.
TEST_P(PixelFilters, ForwardAgreesWithReverse) {
    Bench b(halfLit(GetParam()), {"lamp.emission"});
    const View view = viewOf(b.scene, kEdge, kEdge);
    Image adjoint(kEdge, kEdge, 3, 0);
    for (std::size_t i = 0; i < adjoint.values.size(); ++i)
        adjoint.values[i] = float(i % 7) - 2;
    const Image forward = b.renderer->forward(view, 64, {1, 0, 1}, b.config.differentiable, b.ones());
    std::vector<std::vector<double>> gradients;
    b.renderer->reverse(view, 64, {1, 0, 1}, adjoint, {}, {}, gradients);
    double expected = 0;
    for (std::size_t i = 0; i < adjoint.values.size(); ++i)
        expected += double(adjoint.values[i]) * double(forward.values[i]);
    EXPECT_NEAR(std::accumulate(gradients[0].begin(), gradients[0].end(), 0.0), expected, 1e-4 * std::abs(expected));
}

std::string filterName(const testing::TestParamInfo<PixelFilter>& info) {
    return info.param.kind == PixelFilter::Kind::Box ? "Box" : info.param.kind == PixelFilter::Kind::Tent ? "Tent" : "Gaussian";
}
INSTANTIATE_TEST_SUITE_P(Filters, PixelFilters,
                         testing::Values(PixelFilter{}, PixelFilter{PixelFilter::Kind::Tent, 1, 0}, PixelFilter{PixelFilter::Kind::Gaussian, 2, 0.5f}), filterName);

} // namespace
} // namespace cmpg::test

// White furnace: a closed box whose faces emit Le and reflect rho. Over D segments L = Le (1 - rho^D) / (1 - rho).
#include "support/render_fixture.h"

namespace cmpg::test {
namespace {

double radiance(double emitted, double rho, int depth) { return emitted * (1 - std::pow(rho, depth)) / (1 - rho); }

double derivative(double emitted, double rho, int depth) {
    const double power = std::pow(rho, depth - 1);
    return emitted * ((1 - rho * power) - depth * power * (1 - rho)) / ((1 - rho) * (1 - rho));
}

class Furnace : public testing::TestWithParam<int> {};

TEST_P(Furnace, RadianceAndAlbedoDerivative) {
    const int depth = GetParam();
    RenderConfig config;
    config.maxDepth = std::uint32_t(depth);
    Bench s(bundledScene("furnace"), {"*.baseColor"}, config);
    const Parameter& albedo = s.scene.parameters[s.config.differentiable.at(0)];
    const Parameter& emission = s.scene.parameters[s.scene.select("*.emission").at(0)];
    const double rho = albedo.values[0], emitted = emission.values[0];
    const View view = viewOf(s.scene, 16, 16);

    std::vector<double> values, derivatives;
    for (std::uint32_t i = 0; i < 8; ++i) {
        values.push_back(meanOf(s.renderer->render(view, 64, {i, 0, 0})));
        derivatives.push_back(meanOf(s.renderer->forward(view, 64, {i, 0, 1}, s.config.differentiable, s.ones())));
    }
    const MeanError value = statistics(values), slope = statistics(derivatives);
    const double expected = radiance(emitted, rho, depth), expectedSlope = derivative(emitted, rho, depth);
    // Three standard errors (99.7 %) and 0.2 %, whichever asks more; the error estimate from eight seeds gets a floor of rounding.
    EXPECT_NEAR(value.mean, expected, std::min(3 * value.standardError + 1e-5 * expected, 0.002 * expected));
    EXPECT_NEAR(slope.mean, expectedSlope, std::min(3 * slope.standardError + 1e-5 * expectedSlope, 0.002 * expectedSlope));
}

INSTANTIATE_TEST_SUITE_P(Depth, Furnace, testing::Values(2, 8, 32));

} // namespace
} // namespace cmpg::test

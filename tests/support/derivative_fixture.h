// Forward against reverse derivatives of a bench.
#pragma once

#include "support/render_fixture.h"

#include <numeric>

namespace cmpg::test {

inline std::vector<std::vector<float>> randomDirections(const Bench& s, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(-1, 1);
    std::vector<std::vector<float>> v = s.ones();
    for (auto& direction : v)
        for (float& x : direction)
            x = uniform(random);
    return v;
}

// The image at `step` along the directions, with directions, lights and densities as they are drawn without: of a bench with frozenEvaluation.
inline Image frozenImage(const Bench& s, const View& view, const PassKey& key, const std::vector<std::vector<float>>& directions, float step) {
    for (std::size_t i = 0; i < directions.size(); ++i) {
        const std::uint32_t p = s.config.differentiable[i];
        std::vector<float> values = s.scene.parameters[p].values;
        for (std::size_t k = 0; k < values.size(); ++k)
            values[k] += step * directions[i][k];
        s.renderer->setSecondValues(p, values);
    }
    return s.renderer->render(view, 16, key);
}

// <Jv, w> = <v, J^T w> with the same random numbers: both modes contract the same samples, only rounding differs.
inline void expectForwardAgreesWithReverse(const Bench& s) {
    const View view = viewOf(s.scene, 24, 24);
    const auto directions = randomDirections(s, 1);
    const PassKey key{5, 0, 1};
    const Image forward = s.renderer->forward(view, 16, key, s.config.differentiable, directions);
    Image adjoint(view.width, view.height, 3);
    std::mt19937 random(2);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (float& a : adjoint.values)
        a = uniform(random);
    std::vector<std::vector<double>> gradients;
    s.renderer->reverse(view, 16, key, adjoint, {}, {}, gradients);

    double forwardSum = 0, reverseSum = 0, magnitude = 0;
    for (std::size_t i = 0; i < adjoint.values.size(); ++i) {
        forwardSum += double(forward.values[i]) * adjoint.values[i];
        magnitude += std::abs(double(forward.values[i]) * adjoint.values[i]);
    }
    for (std::size_t p = 0; p < gradients.size(); ++p)
        reverseSum += std::inner_product(gradients[p].begin(), gradients[p].end(), directions[p].begin(), 0.0);
    ASSERT_GT(magnitude, 0);
    EXPECT_NEAR(forwardSum, reverseSum, 1e-4 * magnitude);
}

} // namespace cmpg::test

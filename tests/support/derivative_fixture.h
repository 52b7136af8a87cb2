// Forward against reverse derivatives of a bench.
#pragma once

#include "support/render_fixture.h"

#include <algorithm>
#include <numeric>

namespace cmpg::test {

// Away from the ends of their range, where a lobe that is not there has a derivative but no sample.
inline Scene withBothLobes(Scene scene) {
    for (Parameter& p : scene.parameters) {
        p.materialise();
        if (p.kind == SlotKind::Metallic || p.kind == SlotKind::Specular)
            for (float& v : p.values)
                v = std::clamp(v, 0.1f, 0.9f);
    }
    return scene;
}

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

// A difference of images, on the same paths, against the image of the second values by itself, with the same random numbers.
inline void expectDifference(const ImageDifference& found, const Image& second) {
    double off = 0, size = 0;
    for (std::size_t i = 0; i < second.values.size(); ++i) {
        const double expected = double(found.image.values[i]) - second.values[i];
        off += std::abs(found.difference.values[i] - expected);
        size += std::abs(expected);
    }
    ASSERT_GT(size, 0);
    EXPECT_LT(off, 1e-4 * size);
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

// Forward derivatives of a bench with frozenEvaluation, pixel by pixel; h: of the differences.
inline void expectFrozenDifferences(const Bench& s, float h = 2e-3f) {
    const View view = viewOf(s.scene, 24, 24);
    const PassKey key{7, 0, 1};
    const auto directions = randomDirections(s, 3);
    const Image forward = s.renderer->forward(view, 16, key, s.config.differentiable, directions);

    const auto shifted = [&](float step) { return frozenImage(s, view, key, directions, step); };
    // Richardson's combination of two step sizes leaves an error of the fourth order.
    const Image plus = shifted(h), minus = shifted(-h), plus2 = shifted(2 * h), minus2 = shifted(-2 * h);
    double difference = 0, norm = 0;
    std::size_t far = 0, unusable = 0;
    for (std::size_t i = 0; i < forward.values.size(); ++i) {
        const double narrow = (double(plus.values[i]) - minus.values[i]) / (2 * h), wide = (double(plus2.values[i]) - minus2.values[i]) / (4 * h);
        const double expected = (4 * narrow - wide) / 3;
        // A pixel's own scale: its derivative, and the rounding of its value over the step.
        const double tolerance = 1e-3 * std::abs(expected) + 4e-6 * (std::abs(plus.values[i]) + 1e-3) / h;
        // Where the two steps disagree there is no derivative to compare with: a normal that crosses the horizon makes f jump.
        if (std::abs(narrow - wide) > 0.002 * std::abs(expected) + tolerance) {
            ++unusable;
            continue;
        }
        const double error = forward.values[i] - expected;
        difference += error * error;
        norm += expected * expected;
        far += std::abs(error) > tolerance;
    }
    ASSERT_GT(norm, 0);
    EXPECT_LT(std::sqrt(difference / norm), 1e-3);
    EXPECT_LE(far, forward.values.size() / 200) << "pixels off by more than 1e-3";
    EXPECT_LE(unusable, forward.values.size() / 20) << "pixels without a usable difference";
}

} // namespace cmpg::test

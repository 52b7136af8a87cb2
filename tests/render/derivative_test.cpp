// Forward and reverse derivatives of every slot: against each other, and against finite differences with sampling frozen.
#include "support/derivative_fixture.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <numeric>

namespace cmpg::test {
namespace {

const std::vector<std::string> kSlots = {"*.baseColor", "*.roughness", "*.metallic", "*.specular", "*.emission", "*.normal", "environment.radiance"};

class SlotDerivative : public testing::TestWithParam<std::string> {};

TEST_P(SlotDerivative, ForwardAgreesWithReverse) { expectForwardAgreesWithReverse(Bench(bundledScene("materials"), {GetParam()})); }

// Directions, lights and densities stay at the base values; only f and E are evaluated with the perturbed ones.
TEST_P(SlotDerivative, FrozenFiniteDifferencesPerPixel) {
    RenderConfig config;
    config.frozenEvaluation = true;
    config.maxDepth = 4;
    // Specular changes a pixel by little: the difference of a short step is mostly the rounding of its float.
    expectFrozenDifferences(Bench(withBothLobes(bundledScene("materials")), {GetParam()}, config), GetParam() == "*.specular" ? 8e-3f : 2e-3f);
}

INSTANTIATE_TEST_SUITE_P(Slots, SlotDerivative, testing::ValuesIn(kSlots), [](const auto& slot) {
    std::string name = slot.param;
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name;
});

// Several slots at once are the sum of each alone, with the same random numbers.
TEST(Derivative, SlotsAddUp) {
    const PassKey key{9, 0, 1};
    Bench all(bundledScene("materials"), kSlots);
    const View view = viewOf(all.scene, 16, 16);
    const Image together = all.renderer->forward(view, 4, key, all.config.differentiable, all.ones());
    std::vector<double> sum(together.values.size(), 0.0);
    double norm = 0, difference = 0;
    for (std::size_t i = 0; i < all.config.differentiable.size(); ++i) {
        const std::vector<std::uint32_t> one{all.config.differentiable[i]};
        const std::vector<std::vector<float>> direction{std::vector<float>(all.scene.parameters[one[0]].entries(), 1.0f)};
        const Image alone = all.renderer->forward(view, 4, key, one, direction);
        for (std::size_t k = 0; k < sum.size(); ++k)
            sum[k] += alone.values[k];
    }
    for (std::size_t k = 0; k < sum.size(); ++k) {
        norm += sum[k] * sum[k];
        difference += (sum[k] - together.values[k]) * (sum[k] - together.values[k]);
    }
    ASSERT_GT(norm, 0);
    EXPECT_LT(std::sqrt(difference / norm), 1e-5);
}

// A map so steep that it turns a good part of the normals from where they are seen.
Scene steep() {
    Scene scene = bundledScene("materials");
    for (Parameter& p : scene.parameters)
        if (p.name == "wavy.normal") {
            p.materialise();
            for (std::size_t k = 0; k < p.values.size(); ++k)
                if (k % 3 < 2)
                    p.values[k] *= 8;
        }
    return scene;
}

TEST(Derivative, ForwardAgreesWithReverseBySteepNormals) { expectForwardAgreesWithReverse(Bench(steep(), {"wavy.normal"})); }

TEST(Derivative, FrozenFiniteDifferencesBySteepNormals) {
    RenderConfig config;
    config.frozenEvaluation = true;
    config.maxDepth = 4;
    expectFrozenDifferences(Bench(steep(), {"wavy.normal"}, config));
}

// Normals far from unit length: the derivative grows as the vector gets shorter, beyond what the units of the sums were made for, and
// is none where the vector is zero and the surface's own normal takes its place.
TEST(Derivative, ShortNormals) {
    Bench s(bundledScene("box"), {"white.normal"});
    const View view = viewOf(s.scene, 24, 24);
    const Image adjoint(view.width, view.height, 3, 1.0f);
    const auto gradient = [&](float length) {
        s.renderer->setParameter(s.config.differentiable[0], std::vector<float>{0, 0, length});
        std::vector<std::vector<double>> g;
        s.renderer->reverse(view, 8, {3, 0, 1}, adjoint, {}, {}, g);
        EXPECT_EQ(s.renderer->statistics().dropped.at("scan_tape: saturated gradient"), 0u) << length;
        return g.at(0);
    };
    const auto unit = gradient(1);
    ASSERT_GT(std::abs(unit[0]) + std::abs(unit[1]), 1);
    for (const float length : {0x1p-8f, 0x1p-30f}) {
        const auto g = gradient(length);
        for (int c = 0; c < 2; ++c)
            EXPECT_NEAR(g[c] * length, unit[c], 1e-5 * (std::abs(unit[0]) + std::abs(unit[1]))) << length;
    }
    EXPECT_EQ(gradient(0), std::vector<double>(3, 0.0));
}

// A map of one row is the map that has this row at both poles: the same image, and the sum of both rows' gradients.
TEST(Derivative, EnvironmentOfOneRow) {
    for (const std::uint32_t width : {1u, 5u}) {
        const auto withRows = [&](std::uint32_t rows) {
            Scene scene = bundledScene("environment");
            Parameter& p = scene.parameters[scene.environment->parameter];
            p.width = width;
            p.height = rows;
            p.values.resize(p.entries());
            for (std::size_t i = 0; i < p.values.size(); ++i)
                p.values[i] = 0.5f + 0.3f * float(i % (3 * width));
            return Bench(std::move(scene), {"environment.radiance"});
        };
        Bench one = withRows(1), two = withRows(2);
        const View view = viewOf(one.scene, 24, 24);
        const PassKey key{3, 0, 1};
        const Image oneImage = one.renderer->render(view, 8, key), twoImage = two.renderer->render(view, 8, key);
        ASSERT_GT(meanOf(oneImage), 0.1);
        for (std::size_t k = 0; k < oneImage.values.size(); ++k)
            ASSERT_NEAR(oneImage.values[k], twoImage.values[k], 1e-5f * twoImage.values[k]) << k;
        const auto gradient = [&](Bench& s) {
            std::vector<std::vector<double>> g;
            s.renderer->reverse(view, 8, key, Image(view.width, view.height, 3, 1.0f), {}, {}, g);
            return g.at(0);
        };
        const std::vector<double> g = gradient(one), both = gradient(two);
        for (std::size_t k = 0; k < g.size(); ++k)
            EXPECT_NEAR(g[k], both[k] + both[k + g.size()], 1e-5 * g[k]) << k;
    }
}

// A black room has no radiance to tell the size of its derivatives by.
TEST(Derivative, BrightLampInABlackRoom) {
    Scene scene = bundledScene("box");
    for (Parameter& p : scene.parameters)
        if (p.kind == SlotKind::BaseColor) {
            p.materialise();
            std::fill(p.values.begin(), p.values.end(), 0.0f);
        } else if (p.kind == SlotKind::Emission)
            for (float& v : p.values)
                v *= 1e9f;
    scene.cameras.front().toWorld = glm::translate(glm::mat4(1), glm::vec3(0, 1, 0.5f)) * glm::rotate(glm::mat4(1), -1.5f, glm::vec3(1, 0, 0)); // at the floor
    Bench s(std::move(scene), {"white.baseColor"});
    const View view = viewOf(s.scene, 16, 16);
    const Image adjoint(view.width, view.height, 3, 1.0f);
    const double forward = 3 * 16 * 16 * meanOf(s.renderer->forward(view, 8, {3, 0, 1}, s.config.differentiable, s.ones()));
    std::vector<std::vector<double>> g;
    s.renderer->reverse(view, 8, {3, 0, 1}, adjoint, {}, {}, g);
    ASSERT_GT(forward, 1e9);
    EXPECT_NEAR(std::accumulate(g.at(0).begin(), g.at(0).end(), 0.0), forward, 1e-4 * forward);
    EXPECT_EQ(s.renderer->statistics().dropped.at("scan_tape: saturated gradient"), 0u);
}

// 4096 x 4096 texels: the gradient sums exceed what one binding reaches, so the scan runs once a slice.
TEST(Derivative, FullLargeTexture) {
    Scene scene = bundledScene("box");
    Parameter& p = scene.parameters[scene.parameter("painting.baseColor")];
    p.width = p.height = 4096;
    p.bytes.clear();
    p.values.assign(p.entries(), 0.0f);
    for (std::size_t i = 0; i < p.values.size(); ++i)
        p.values[i] = 0.2f + 0.6f * float(i % 977) / 977.0f;
    Bench s(std::move(scene), {"painting.baseColor"});
    ASSERT_GT(s.ones()[0].size() * 8, device().info().maxStorageBufferRange);
    const View view = viewOf(s.scene, 64, 64);
    const PassKey key{5, 0, 1};
    const Image forward = s.renderer->forward(view, 4, key, s.config.differentiable, s.ones());
    std::vector<std::vector<double>> gradients;
    s.renderer->reverse(view, 4, key, Image(64, 64, 3, 1.0f), {}, {}, gradients);
    const double forwardSum = meanOf(forward) * double(forward.values.size());
    const double reverseSum = std::accumulate(gradients[0].begin(), gradients[0].end(), 0.0);
    ASSERT_GT(forwardSum, 0);
    EXPECT_NEAR(reverseSum, forwardSum, 1e-4 * forwardSum);
}

// A black albedo has a derivative: light that would be reflected if it were not black.
TEST(Derivative, BlackAlbedo) {
    Bench black(bundledScene("box"), {"painting.baseColor"});
    const View view = viewOf(black.scene, 32, 32);
    const std::uint32_t p = black.config.differentiable[0];
    const std::size_t entries = black.scene.parameters[p].entries();
    std::vector<double> slopes, differences;
    for (std::uint32_t i = 0; i < 8; ++i) {
        black.renderer->setParameter(p, std::vector<float>(entries, 0.0f));
        slopes.push_back(meanOf(black.renderer->forward(view, 32, {i, 0, 1}, black.config.differentiable, black.ones())));
        const double dark = meanOf(black.renderer->render(view, 32, {i + 100, 0, 0}));
        black.renderer->setParameter(p, std::vector<float>(entries, 0.02f));
        differences.push_back((meanOf(black.renderer->render(view, 32, {i + 100, 0, 0})) - dark) / 0.02);
    }
    const MeanError slope = statistics(slopes), difference = statistics(differences);
    ASSERT_GT(difference.mean, 0);
    // Four joint standard errors, and the second-order term of the finite step.
    EXPECT_NEAR(slope.mean, difference.mean, 4 * std::hypot(slope.standardError, difference.standardError) + 0.01 * difference.mean);
}

} // namespace
} // namespace cmpg::test

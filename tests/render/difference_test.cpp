// An image and how it differs from that of a second set of values, along the same paths.
#include "support/derivative_fixture.h"
#include "support/material_json.h"

#include <cmath>

namespace cmpg::test {
namespace {

const std::vector<std::string> kSlots = {"*.baseColor", "*.roughness", "*.metallic", "*.specular", "*.emission", "*.normal", "environment.radiance"};

RenderConfig withSecondValues(bool frozen) {
    RenderConfig config;
    config.differences = !frozen;
    config.frozenEvaluation = frozen;
    config.maxDepth = 4;
    return config;
}

std::vector<float> moved(const Parameter& p, float step) {
    std::vector<float> values = p.values;
    for (std::size_t i = 0; i < values.size(); ++i)
        values[i] = std::clamp(values[i] + (i % 2 == 0 ? step : -step), p.kind == SlotKind::Normal ? -1.0f : 0.0f, p.highest());
    return values;
}

class Difference : public testing::TestWithParam<std::string> {};

// Against two images of which one is made with the second values alone. What is sampled is the same in all.
TEST_P(Difference, IsThatOfImagesAlongTheSamePaths) {
    Bench both(withBothLobes(bundledScene("materials")), {GetParam()}, withSecondValues(false));
    Bench second(withBothLobes(bundledScene("materials")), {GetParam()}, withSecondValues(true));
    const View view = viewOf(both.scene, 24, 24);
    const PassKey key{7, 0, 1};
    const ImageDifference same = both.renderer->renderDifference(view, 16, key);
    EXPECT_EQ(same.image.values, second.renderer->render(view, 16, key).values);
    for (const float d : same.difference.values)
        ASSERT_EQ(d, 0.0f);

    for (const std::uint32_t p : both.config.differentiable) {
        const std::vector<float> values = moved(both.scene.parameters[p], 0.05f);
        both.renderer->setSecondValues(p, values);
        second.renderer->setSecondValues(p, values);
    }
    const ImageDifference found = both.renderer->renderDifference(view, 16, key);
    EXPECT_EQ(found.image.values, same.image.values);
    const Image other = second.renderer->render(view, 16, key);
    expectDifference(found, other);
}

// The same choice between the materials of a blend, by the first set of values.
TEST(Difference, FollowsTheWeightOfABlend) {
    const auto scene = [] {
        Scene s = bundledScene("materials");
        addBlend(s, "varied", "brass", 0.3f);
        return s;
    };
    Bench both(scene(), {"varied.weight"}, withSecondValues(false)), second(scene(), {"varied.weight"}, withSecondValues(true));
    const View view = viewOf(both.scene, 24, 24);
    for (const Bench* s : {&both, &second})
        s->renderer->setSecondValues(s->config.differentiable[0], std::vector<float>{0.4f});
    const ImageDifference found = both.renderer->renderDifference(view, 16, {7, 0, 1});
    const Image other = second.renderer->render(view, 16, {7, 0, 1});
    expectDifference(found, other);
}

INSTANTIATE_TEST_SUITE_P(Slots, Difference, testing::ValuesIn(kSlots), [](const auto& slot) {
    std::string name = slot.param;
    std::erase_if(name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
    return name;
});

// Kernels of differences read the second values of differentiated slots alone; frozen ones read all.
TEST(Difference, RefusesSecondValuesThatItWouldNotRead) {
    for (const bool frozen : {false, true}) {
        Bench s(bundledScene("box"), {"painting.baseColor"}, withSecondValues(frozen));
        const std::uint32_t other = s.scene.parameter("white.baseColor");
        const auto set = [&] { s.renderer->setSecondValues(other, moved(s.scene.parameters[other], 0.1f)); };
        if (frozen)
            EXPECT_NO_THROW(set());
        else
            EXPECT_THROW(set(), std::logic_error);
    }
}

// A few samples a batch: pixels go on from one batch to the next.
TEST(Difference, DoesNotDependOnTheMemory) {
    const PassKey key{3, 0, 1};
    std::vector<std::vector<float>> images, differences;
    for (const std::uint64_t budget : {std::uint64_t(1) << 30, std::uint64_t(16) << 20}) {
        RenderConfig config = withSecondValues(false);
        config.memoryBudget = budget;
        Bench s(bundledScene("box"), {"painting.baseColor"}, config);
        const std::uint32_t p = s.config.differentiable[0];
        s.renderer->setSecondValues(p, moved(s.scene.parameters[p], 0.1f));
        ImageDifference found = s.renderer->renderDifference(viewOf(s.scene, 64, 64), 16, key);
        images.push_back(std::move(found.image.values));
        differences.push_back(std::move(found.difference.values));
    }
    EXPECT_EQ(images[0], images[1]);
    EXPECT_EQ(differences[0], differences[1]);
}

// Passes whose samples follow one another in every pixel are one pass of all.
TEST(SampleRanges, GoOnWhereThoseBeforeEnded) {
    Bench b(bundledScene("materials"), {"painting.baseColor"}, withSecondValues(false));
    const View view = viewOf(b.scene, 24, 24);
    const std::uint32_t painting = b.config.differentiable[0];
    b.renderer->setSecondValues(painting, moved(b.scene.parameters[painting], 0.05f));
    std::vector<std::uint32_t> before, after, all;
    for (std::uint32_t p = 0; p < 24 * 24; ++p) {
        before.push_back(1 + p % 5);
        after.push_back(1 + p * 7 % 6);
        all.push_back(before.back() + after.back());
    }
    const PassKey key{7, 0, 1};
    const ImageDifference first = b.renderer->renderDifference(view, 5, key, {before, {}}), second = b.renderer->renderDifference(view, 6, key, {after, before});
    const ImageDifference whole = b.renderer->renderDifference(view, 11, key, {all, {}});
    for (std::size_t p = 0; p < all.size(); ++p)
        for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) {
            const float n = float(before[p]), m = float(after[p]);
            EXPECT_NEAR((n * first.image.values[i] + m * second.image.values[i]) / (n + m), whole.image.values[i], 1e-5f * (1 + whole.image.values[i])) << p;
            EXPECT_NEAR((n * first.difference.values[i] + m * second.difference.values[i]) / (n + m), whole.difference.values[i], 1e-5f) << p;
        }
}

} // namespace
} // namespace cmpg::test

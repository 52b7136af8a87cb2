// Changes that must not change images or derivatives, on random and bundled scenes.
#include "checker.h"
#include "random_scene.h"

#include <cstdlib>
#include <ctime>

namespace cmpg::test {
namespace {

constexpr std::uint32_t kOutputs = 14; // compared of a scene and relation

Scene sceneCalled(const std::string& name, std::uint32_t& seed) {
    const auto number = [&](const char* kind) { return std::uint32_t(std::stoul(name.substr(std::string(kind).size()))); };
    if (name.rfind("random ", 0) == 0)
        return randomScene(seed = number("random "));
    if (name.rfind("tame ", 0) == 0)
        return randomScene(seed = number("tame "), {.tame = true});
    if (name.rfind("matt ", 0) == 0)
        return randomScene(seed = number("matt "), {.matt = true});
    seed = 1;
    return bundledScene(name);
}

// Every `stride`-th of the relations that apply, others from scene to scene; those for tame scenes always.
void checkScene(Checker& checker, const std::string& name, std::uint32_t stride) {
    std::uint32_t seed = 0;
    const Scene scene = sceneCalled(name, seed);
    const bool tame = name.rfind("tame ", 0) == 0;
    checker.begin(name, seed, scene);
    std::uint32_t at = seed % stride;
    for (const Relation& r : relations())
        if (r.applies(scene) && (r.tame ? tame : at++ % stride == 0))
            checker.check(r);
}

// How far it is, for who watches a long run.
void tick(std::uint32_t scenes) {
    if (scenes % 50 == 0)
        std::fprintf(stderr, "%u scenes, %.0f s of processor time\n", scenes, double(std::clock()) / CLOCKS_PER_SEC);
}

void report(const Checker& checker) {
    std::string text;
    for (const auto& [relation, scenes] : checker.scenes())
        text += "  " + std::to_string(scenes) + " " + relation + "\n";
    std::printf("%.0f s of processor time, %zu comparisons; scenes by relation:\n%s", double(std::clock()) / CLOCKS_PER_SEC, checker.comparisons(), text.c_str());
}

// Scenes `first` to `first + count`.
void checkRandomScenes(std::uint32_t first, std::uint32_t count, std::uint32_t stride) {
    constexpr std::array<const char*, 4> kKinds{"random ", "matt ", "random ", "tame "};
    Checker checker(count * double(relations().size()) / stride * kOutputs);
    for (std::uint32_t i = 0; i < count; ++i) {
        checkScene(checker, kKinds[(first + i) % 4] + std::to_string(first + i), stride);
        tick(i + 1);
    }
    checker.finish();
    report(checker);
}

TEST(Metamorphic, RandomScenes) { checkRandomScenes(0, 5, 5); } // every relation comes up once
TEST(Metamorphic, FullFewRandomScenes) { checkRandomScenes(5, 3, 5); }

// Light samples for both sides of what reflects diffusely alone: where each of a few scenes is needed to tell. Their images do, with what kernels each requires.
TEST(Metamorphic, FullCornersRunEitherWay) {
    constexpr std::uint32_t kScenes = 16;
    const Relation& reversed = relations().front();
    for (std::uint32_t i = 0; i < kScenes; ++i) {
        const Scene scene = randomScene(i, {.matt = true});
        generated::Random random(i);
        const std::vector<Image> own = images(scene, {}), other = images(reversed.terms(scene, random).front().scene, {});
        for (const Comparison& c : compareImages("image", own, other, reversed.tolerance))
            EXPECT_LE(c.score(), allowedScore(kScenes * 7)) << "matt " << i << ", " << c.what << ": " << c.difference / c.size * 200 << " % apart";
    }
}

TEST(Metamorphic, FullRandomScenes) { checkRandomScenes(1000, 500, 9); }
TEST(Metamorphic, FullMoreRandomScenes) { checkRandomScenes(1500, 500, 9); }

TEST(Metamorphic, FullBundledScenes) {
    Checker checker(6 * double(relations().size()) * kOutputs, 16);
    for (const char* name : {"box", "door", "bowl", "environment", "materials", "occluded"})
        checkScene(checker, name, 1);
    report(checker);
}

// What a failure says how to repeat.
TEST(Metamorphic, OneScene) {
    const char *name = std::getenv("CMPG_METAMORPHIC_SCENE"), *relation = std::getenv("CMPG_METAMORPHIC_RELATION");
    if (!name)
        GTEST_SKIP() << "no scene is named: CMPG_METAMORPHIC_SCENE";
    Checker checker(1e6);
    std::uint32_t seed = 0;
    Scene scene = sceneCalled(name, seed);
    checker.begin(name, seed, scene);
    for (const Relation& r : relations())
        if (r.applies(scene) && (!relation || r.name == relation))
            checker.check(r);
}

} // namespace
} // namespace cmpg::test

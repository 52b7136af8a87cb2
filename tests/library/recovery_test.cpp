// Recoveries of the library find what the program finds.
#include "library_fixture.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>

namespace cmpg::test {
namespace {

TEST(LibraryRecovery, FindsWhatTheProgramFinds) {
    const Folder folder;
    const Target target = smallTarget();
    saveImage(folder / "target.exr", target.image);
    ASSERT_TRUE(program("optimize " + kBox + " --param " + kPainting + " --set " + kPainting + "=0.5 --steps 4 --target " + (folder / "target.exr") +
                        " -o " + (folder / "run")));
    RecoveryOptions options;
    options.parameters = {kPainting};
    const Scene scene = greyScene();
    Recovery recovery(device(), scene, {Target::load(folder / "target.exr")}, options);
    for (int i = 0; i < 4; ++i)
        recovery.step();
    EXPECT_EQ(recovery.values(kPainting), loadImage(folder / "run/parameters/painting.baseColor.exr").values);
    const std::vector<double> gradient = recovery.gradient(kPainting);
    EXPECT_EQ(std::vector<float>(gradient.begin(), gradient.end()), loadImage(folder / "run/gradients/painting.baseColor.exr").values);
    EXPECT_EQ(recovery.image().values, loadImage(folder / "run/final.exr").values);
    EXPECT_EQ(scene.values(kPainting), std::vector<float>(64 * 64 * 3, 0.5f));
}

TEST(LibraryRecovery, LossFallsAndScenesTakeTheResult) {
    Scene scene = greyScene();
    RecoveryOptions options = paintingOptions();
    options.steps = 6;
    options.sppDifference = 0;
    options.spp = 512; // the loss is one without the image's noise, and negative where that is larger than it
    const Target target{"", Renderer(device(), Scene::load(kBox), {.paths = options.paths}).render({.width = 32, .spp = 1024, .seed = 1})};
    Recovery recovery(device(), scene, {target}, options);
    std::vector<double> losses;
    while (!recovery.done())
        losses.push_back(recovery.step().loss);
    ASSERT_EQ(losses.size(), 6u);
    EXPECT_LT(losses.back(), 0.65 * losses.front()); // 0.58 to 0.59 with seeds 0 to 2
    recovery.apply(scene);
    EXPECT_EQ(scene.values(kPainting), recovery.values(kPainting));
}

// Its largest channel takes light from what is below in all channels of the image.
TEST(LibraryRecovery, FindsTheColourOfASheen) {
    const Folder folder;
    std::filesystem::copy(std::filesystem::path(kBox).parent_path(), folder / "box");
    nlohmann::json json = nlohmann::json::parse(std::ifstream(kBox));
    json["extensionsUsed"].push_back("KHR_materials_sheen");
    const std::vector<float> truth{0.8f, 0.5f, 0.2f};
    for (nlohmann::json& material : json["materials"])
        if (material["name"] == "left")
            material["extensions"]["KHR_materials_sheen"] = {{"sheenColorFactor", truth}, {"sheenRoughnessFactor", 0.5}};
    std::ofstream(folder / "box/scene.gltf") << json;
    Scene scene = Scene::load(folder / "box/scene.gltf");
    scene.set("left.baseColor", std::vector{0.8f}); // not red, so that all channels see the light below go
    const Target target{"", Renderer(device(), scene).render({.width = 32, .spp = 256})};
    scene.set("left.sheenColor", std::vector{0.3f});
    RecoveryOptions options;
    options.parameters = {"left.sheenColor"};
    options.steps = 20;
    Recovery recovery(device(), scene, {target}, options);
    while (!recovery.done())
        recovery.step();
    const std::vector<float> found = recovery.values("left.sheenColor");
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(found[c], truth[c], 0.02) << c;
}

// Twelve texels along the edge of a pixel: with a prior as heavy as that of coarse ones the error is 0.02.
TEST(LibraryRecovery, HoldsFineTexturesLess) {
    constexpr std::uint32_t kSize = 192, kSquare = 48;
    Scene scene = Scene::load(kBox);
    scene.resize(kPainting, kSize, kSize);
    std::vector<float> truth;
    for (std::uint32_t i = 0; i < kSize * kSize; ++i) {
        const float value = (i % kSize / kSquare + i / kSize / kSquare) % 2 == 0 ? 0.8f : 0.2f;
        truth.insert(truth.end(), {value, 0.8f * value, 0.6f * value});
    }
    scene.set(kPainting, truth);
    const Target target{"", Renderer(device(), scene).render({.width = 48, .height = 48, .spp = 256})};
    scene.set(kPainting, std::vector{0.5f});
    RecoveryOptions options;
    options.parameters = {kPainting};
    options.steps = 15;
    Recovery recovery(device(), scene, {target}, options);
    while (!recovery.done())
        recovery.step();
    const std::vector<float> found = recovery.values(kPainting);
    double square = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
        square += (double(found[i]) - truth[i]) * (double(found[i]) - truth[i]);
    EXPECT_LT(square / double(found.size()), 0.014);
}

// Sixteen texels along the edge of a pixel step on a grid of fewer: what differs from texel to texel at the start stays, and steps are interpolated.
TEST(LibraryRecovery, StepsTexturesFarFinerThanPixelsOnACoarserGrid) {
    constexpr int kSize = 256;
    const Folder folder;
    Scene scene = Scene::load(kBox);
    scene.resize(kPainting, kSize, kSize);
    const Target target{"", Renderer(device(), scene).render({.width = 48, .height = 48, .spp = 64})};
    std::vector<float> start;
    for (int i = 0; i < kSize * kSize * 3; ++i)
        start.push_back((i / 3 % kSize + i / 3 / kSize) % 2 == 0 ? 0.45f : 0.55f);
    scene.set(kPainting, start);
    RecoveryOptions options;
    options.parameters = {kPainting};
    const Renderer renderer(device(), scene, {.parameters = {kPainting}, .recoveries = true});
    Recovery recovery(renderer, {target}, options);
    while (recovery.steps() < 3)
        recovery.step();
    recovery.save(folder / "kept");
    while (recovery.steps() < 5)
        recovery.step();
    const std::vector<float> found = recovery.values(kPainting);
    double moved = 0, straight = 0, count = 0;
    for (std::size_t i = 3; i + 3 < found.size(); ++i) {
        const auto change = [&](std::size_t k) { return double(found[k]) - start[k]; };
        moved = std::max(moved, std::abs(change(i)));
        const bool free = std::min({found[i - 3], found[i], found[i + 3]}) > 0 && std::max({found[i - 3], found[i], found[i + 3]}) < 1;
        if (const std::size_t x = i / 3 % kSize; x > 0 && x + 1 < kSize && free) {
            straight += std::abs(change(i - 3) - 2 * change(i) + change(i + 3)) < 1e-5;
            ++count;
        }
    }
    EXPECT_GT(moved, 0.3);
    EXPECT_GT(straight / count, 0.3) << "of the texels between every fourth half, but where one stopped at a bound";
    EXPECT_LT(straight / count, 0.95);
    ASSERT_TRUE(recovery.resume(folder / "kept"));
    while (recovery.steps() < 5)
        recovery.step();
    EXPECT_EQ(recovery.values(kPainting), found);

    // Without a prior nothing is known of the grid that the texture stepped on.
    options.prior = 0;
    Recovery other(renderer, {target}, options, recovery.progress());
    other.step();
    EXPECT_NE(other.values(kPainting), found);
}

// A texel has the samples of all its pixels. How many these are is measured for the prior. Roughness, whose derivatives are noisier, keeps all.
TEST(LibraryRecovery, TexelsOfManyPixelsTakeFewerSamplesOfEach) {
    Scene scene = Scene::load(kBox);
    for (const std::string& texture : {kPainting, std::string("painting.roughness")})
        scene.resize(texture, 8, 8);
    const Target target{"", Renderer(device(), scene).render({.width = 64, .height = 64, .spp = 16})};
    const auto paths = [&](const std::string& parameter, float prior) {
        RecoveryOptions options;
        options.parameters = {parameter};
        options.prior = prior;
        const Renderer renderer(device(), scene, {.parameters = {parameter}, .recoveries = true});
        Recovery recovery(renderer, {target}, options);
        recovery.step();
        return double(recovery.step().paths);
    };
    EXPECT_LT(paths(kPainting, 8), 0.75 * paths(kPainting, 0));
    EXPECT_EQ(paths("painting.roughness", 8), paths("painting.roughness", 0));
}

TEST(LibraryRecovery, ExpectsWhatTheNextStepTakes) {
    RecoveryOptions options = paintingOptions();
    options.viewsPerStep = 0;
    options.paths.sampling = Sampling::Bsdf; // the first step compiles all kernels that there will be
    options.paths.roulette = false;
    Recovery recovery(device(), greyScene(), {smallTarget(), smallTarget(), smallTarget(), smallTarget()}, options);
    std::vector<double> seconds;
    for (int i = 0; i < 8; ++i) {
        const RecoveryStep step = recovery.step();
        EXPECT_TRUE(i > 0 || step.compileSeconds > 0); // later ones may have all they need
        seconds.push_back(step.seconds - step.compileSeconds);
        std::vector<double> last(seconds.end() - std::min<std::ptrdiff_t>(5, std::ssize(seconds)), seconds.end());
        std::sort(last.begin(), last.end());
        // Four steps of one view, which measure the curvature, four of two views, and one of all, which measures it.
        EXPECT_DOUBLE_EQ(step.nextSeconds, last[last.size() / 2] * (i < 7 ? 1 : 4)) << i;
    }
}

// A gradient that is mostly noise: the second step begins to learn a guide, with kernels that record.
TEST(LibraryRecovery, ExpectsWhatTheNextStepCompiles) {
    RecoveryOptions options = paintingOptions();
    options.spp = options.sppGradient = 2;
    Scene scene = Scene::load(CMPG_SOURCE_DIR "/scenes/door/scene.gltf");
    scene.set(kPainting, std::vector{0.5f});
    Recovery recovery(device(), scene, {Target{"", Image(16, 16, 3, 0.5f)}}, options);
    const RecoveryStep step = recovery.step();
    EXPECT_GT(step.compileSeconds, 0);
    // Half of what it ran, since it measured the curvature as well, and as much for kernels of images and derivatives as it took for its own.
    EXPECT_GT(step.nextSeconds, 0.5 * (step.seconds - step.compileSeconds) + 0.9 * step.compileSeconds);
}

TEST(LibraryRecovery, TellsALossWithItsDerivative) {
    Target target{.image = Image(2, 1, 3, 0.5f), .mask = {1, 0}};
    Image image(2, 1, 3, 0.75f);
    const ImageLoss found = lossOf(Loss::Mse, image, target);
    EXPECT_NEAR(found.value, 0.0625, 1e-9);
    EXPECT_NEAR(found.adjoint.at(0, 0)[1], 2 * 0.25 / 3, 1e-6);
    EXPECT_EQ(found.adjoint.at(1, 0)[1], 0);
    EXPECT_EQ(lossOf(Loss::Mse, image, {.image = Image(2, 1, 0), .read = [&] { return target; }}).value, found.value);
    target.clipped.assign(6, 1);
    EXPECT_EQ(lossOf(Loss::Mse, image, target).value, 0); // brighter than what was clipped
    target.clipped.resize(2); // one for each value
    EXPECT_EQ(errorOf([&] { lossOf(Loss::Mse, image, target); }).kind, ErrorKind::Usage);
    target.clipped.clear();
    image.values[0] = NAN;
    EXPECT_EQ(lossOf(Loss::L1, image, {.image = target.image}).nonFinite, 1u);
    EXPECT_EQ(errorOf([&] { lossOf(Loss::Mse, Image(3, 1, 3), target); }).kind, ErrorKind::Input);
}

// The lamp is in the picture, clipped, and changes more than all that it lights: its pixels must not tell how far a step may go.
TEST(LibraryRecovery, FindsLightWhoseLampIsClipped) {
    Target target = smallTarget();
    for (float& value : target.image.values) {
        target.clipped.push_back(value >= 1);
        value = std::min(value, 1.f);
    }
    EXPECT_GT(std::accumulate(target.clipped.begin(), target.clipped.end(), 0), 20);
    Scene scene = Scene::load(kBox);
    const std::vector<float> truth = scene.values("light.emission");
    scene.set("light.emission", std::vector<float>(3, 5));
    RecoveryOptions options;
    options.parameters = {"light.emission"};
    Recovery recovery(device(), scene, {target}, options);
    for (int i = 0; i < 12; ++i)
        recovery.step();
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(recovery.values("light.emission")[c], truth[c], 0.05 * truth[c]);

    Image brighter = target.image;
    for (float& value : brighter.values)
        value += 0.5f;
    const Image difference = recovery.difference(brighter);
    for (std::size_t i = 0; i < difference.values.size(); ++i)
        EXPECT_NEAR(difference.values[i], target.clipped[i] ? 0 : 0.5, 1e-6);
    EXPECT_THROW(recovery.difference(Image(3, 3, 3)), Error);
}

TEST(LibraryRecovery, ReadsTargetsWhenStepsSeeThem) {
    const Folder folder;
    const Scene scene = greyScene();
    saveImage(folder / "target.exr", smallTarget().image);
    const Target kept = Target::load(folder / "target.exr"), streamed = Target::stream(folder / "target.exr");
    EXPECT_TRUE(streamed.image.values.empty());
    EXPECT_EQ(streamed.image.width, 32);
    Recovery one(device(), scene, {kept, kept}, paintingOptions()), other(device(), scene, {kept, streamed}, paintingOptions());
    for (int i = 0; i < 2; ++i) {
        one.step();
        other.step();
    }
    EXPECT_EQ(one.values(kPainting), other.values(kPainting));
    EXPECT_EQ(other.target(1).values, kept.image.values);

    saveImage(folder / "target.exr", smallTarget(2).image);
    const Error changed = errorOf([&] { other.step(); });
    EXPECT_EQ(changed.kind, ErrorKind::Input);
    EXPECT_NE(std::string(changed.what()).find("target.exr"), std::string::npos) << changed.what();
    EXPECT_EQ(other.steps(), 2u);
    EXPECT_EQ(other.values(kPainting), one.values(kPainting)); // nothing is lost
    std::filesystem::remove(folder / "target.exr");
    EXPECT_EQ(errorOf([&] { other.step(); }).kind, ErrorKind::Input);
}

// The camera sees half of the floor's bricks, from which the rest is guessed after eight steps.
TEST(LibraryRecovery, GuessesWhatNoCameraSeesAndResumesWithIt) {
    const Folder folder;
    const std::string floor = "painting.baseColor";
    Scene scene = Scene::load(std::string(CMPG_SOURCE_DIR) + "/scenes/environment/scene.gltf");
    std::vector<float> truth; // bricks, of 64 x 64 texels
    for (int i = 0; i < 64 * 64 * 3; ++i) {
        const int x = i / 3 % 64, y = i / 3 / 64;
        truth.push_back(y % 8 == 0 || (x + y / 8 % 2 * 8) % 16 == 0 ? 0.8f : 0.3f);
    }
    scene.set(floor, truth);
    const Target target{"", Renderer(device(), scene).render({.width = 96, .spp = 64, .seed = 1})};
    scene.set(floor, std::vector{0.5f});
    RecoveryOptions options;
    options.parameters = {floor};
    Recovery recovery(device(), scene, {target}, options);
    while (recovery.steps() < 10)
        recovery.step();
    recovery.save(folder / "kept");
    while (recovery.steps() < 16)
        recovery.step();
    const std::vector<float> values = recovery.values(floor);
    ASSERT_TRUE(recovery.resume(folder / "kept"));
    while (recovery.steps() < 16)
        recovery.step();
    EXPECT_EQ(recovery.values(floor), values);
    while (recovery.steps() < 24)
        recovery.step();

    // A corner that the camera does not see.
    const std::vector<float> found = recovery.values(floor);
    double error = 0, mean = 0, squares = 0, count = 0;
    for (int y = 44; y < 64; ++y)
        for (int i = (y * 64) * 3; i < (y * 64 + 6) * 3; ++i) {
            error += (double(found[std::size_t(i)]) - truth[std::size_t(i)]) * (double(found[std::size_t(i)]) - truth[std::size_t(i)]);
            mean += truth[std::size_t(i)];
            squares += double(truth[std::size_t(i)]) * truth[std::size_t(i)];
            ++count;
        }
    const double variance = squares / count - mean / count * mean / count;
    EXPECT_LT(error / count, 0.4 * variance) << variance;
}

TEST(LibraryRecovery, ShowsWhatItBeganWithAndWhatItDid) {
    const Scene scene = greyScene();
    Recovery recovery(device(), scene, {smallTarget()}, paintingOptions());
    const Image start = recovery.image(0, 4);
    int shown = 0;
    recovery.onImage([&](std::size_t target, const Image& image) {
        EXPECT_EQ(target, 0u);
        EXPECT_EQ(image.width, 32);
        ++shown;
    });
    recovery.prepare();
    const RecoveryStep step = recovery.step();
    EXPECT_EQ(shown, 1);
    EXPECT_GE(step.paths, 32u * 32 * 16);
    EXPECT_LE(step.imageSeconds + step.gradientSeconds + step.updateSeconds, step.seconds);
    // Between two passes of other values nothing of them stays behind.
    const Image after = recovery.image(0, 4);
    EXPECT_NE(after.values, start.values);
    EXPECT_EQ(recovery.image(0, 4, true).values, start.values);
    EXPECT_EQ(recovery.image(0, 4).values, after.values);
    EXPECT_EQ(recovery.target().values, smallTarget().image.values);
    EXPECT_EQ(errorOf([&] { recovery.target(1); }).kind, ErrorKind::Usage);
    const PassReport report = recovery.report();
    EXPECT_EQ(report.width, 32);
    EXPECT_GT(report.paths, step.paths);
    EXPECT_TRUE(report.guided);
    EXPECT_TRUE(report.dropped.empty() || report.dropped.begin()->second == 0);
    EXPECT_EQ(recovery.step().step, 1u);
}

TEST(LibraryRecovery, GradientsReachTheirErrorAndGuidesAreKept) {
    const Folder folder;
    RecoveryOptions options = paintingOptions();
    options.errorTarget = 0.5;
    options.sppGradient = 64;
    options.paths.guide.keep = true;
    Recovery recovery(device(), greyScene(), {smallTarget()}, options);
    recovery.step();
    recovery.step();
    EXPECT_GE(recovery.errors().gradients, 2u);
    EXPECT_EQ(recovery.errors().missed, 0u);
    recovery.saveGuide(folder / "guide");
    options.paths.guide.load = folder / "guide";
    options.spp = 512; // for a loss above its noise
    EXPECT_GT(Recovery(device(), greyScene(), {smallTarget()}, options).step().loss, 0);
    options.sppGradient = 4;
    EXPECT_EQ(errorOf([&] { Recovery(device(), greyScene(), {smallTarget()}, options); }).options, std::vector<std::string>{"spp-gradient"});
}

TEST(LibraryRecovery, AStepThatIsEndedCanBeDoneAgain) {
    const Scene scene = greyScene();
    const std::vector<Target> targets{smallTarget()};
    Recovery ended(device(), scene, targets, paintingOptions()), whole(device(), scene, targets, paintingOptions());
    struct Ended {};
    int calls = 0;
    ended.onSubmission([&] {
        if (++calls == 4)
            throw Ended{};
    });
    EXPECT_THROW(ended.step(), Ended);
    EXPECT_EQ(ended.steps(), 0u);
    for (int i = 0; i < 2; ++i) {
        ended.step();
        whole.step();
    }
    EXPECT_EQ(ended.values(kPainting), whole.values(kPainting));
    const std::vector<double> gradient = ended.gradient(kPainting);
    ended.onSubmission([] { throw Ended{}; });
    EXPECT_THROW(ended.step(), Ended);
    EXPECT_EQ(ended.gradient(kPainting), gradient) << "of the last whole step";
}

TEST(LibraryRecovery, RefusesWhatMakesNoSense) {
    const Scene scene = Scene::load(kBox);
    const std::vector<Target> targets{{"", Image(16, 16, 3, 0.5f)}};
    const auto refuses = [&](const auto& change) {
        RecoveryOptions options = paintingOptions();
        change(options);
        return errorOf([&] { Recovery(device(), scene, targets, options); });
    };
    EXPECT_EQ(refuses([](RecoveryOptions& o) { o.parameters.clear(); }).options, std::vector<std::string>{"param"});
    EXPECT_EQ(refuses([](RecoveryOptions& o) { o.steps = 0; }).options, std::vector<std::string>{"steps"});
    EXPECT_EQ(refuses([](RecoveryOptions& o) { o.sppDifference = 1; }).options, std::vector<std::string>{"spp-difference"});
    EXPECT_EQ(refuses([](RecoveryOptions& o) { o.rates = {{"colour", 0.1f}}; }).options, std::vector<std::string>{"rate"});
    EXPECT_EQ(refuses([](RecoveryOptions& o) {
                  o.optimizer = OptimizerKind::GaussNewton;
                  o.loss = Loss::L1;
              }).kind,
              ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { Recovery(device(), scene, {}, paintingOptions()); }).options, std::vector<std::string>{"target"});
    EXPECT_EQ(errorOf([&] { Recovery(device(), scene, {{"nobody", Image(8, 8, 3)}}, paintingOptions()); }).kind, ErrorKind::Usage);
}

} // namespace
} // namespace cmpg::test

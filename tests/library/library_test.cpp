// The library as other programs use it: by its headers and its shared object alone. What the command line writes is the yardstick.
#include <cmpg/cmpg.h>

#include "support/thread_ranks.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <gtest/gtest.h>
#include <thread>
#include <unistd.h>

namespace {

using namespace cmpg;
namespace fs = std::filesystem;

const std::string kBox = CMPG_SOURCE_DIR "/scenes/box/scene.gltf";
const std::string kPainting = "painting.baseColor"; // 64 x 64 x 3

Device& device() {
    static Device d;
    return d;
}

class Folder {
  public:
    Folder() : path_(fs::temp_directory_path() / ("cmpg-library-" + std::to_string(getpid()) + "-" + std::to_string(++number_))) {
        fs::create_directories(path_);
    }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    std::string operator/(const std::string& name) const { return (path_ / name).string(); }

  private:
    static inline int number_ = 0;
    fs::path path_;
};

// Runs the program; whether it ended well.
bool program(const std::string& arguments) {
    return std::system((std::string(CMPG_BINARY) + " --headless --quiet " + arguments + " > /dev/null 2>&1").c_str()) == 0;
}

Scene greyScene() {
    Scene scene = Scene::load(kBox);
    scene.set(kPainting, std::vector{0.5f});
    return scene;
}

RecoveryOptions paintingOptions() {
    RecoveryOptions options;
    options.parameters = {kPainting};
    options.paths.maxDepth = 4;
    return options;
}

// A picture of the true scene, small.
Target smallTarget(std::uint64_t seed = 1) { return {"", Renderer(device(), Scene::load(kBox)).render({.width = 32, .spp = 32, .seed = seed})}; }

Error errorOf(const auto& action) {
    try {
        action();
    } catch (const Error& error) {
        return error;
    }
    ADD_FAILURE() << "nothing was thrown";
    return {ErrorKind::Usage, ""};
}

TEST(LibraryScene, ValuesAreRangesAndShapesOfTheFile) {
    Scene scene = Scene::load(kBox);
    const ParameterInfo info = scene.parameter(kPainting);
    EXPECT_EQ(info.slot, "baseColor");
    EXPECT_EQ(info.height, 64);
    EXPECT_EQ(info.width, 64);
    EXPECT_EQ(info.channels, 3);
    EXPECT_EQ(info.lowest, 0);
    EXPECT_EQ(info.highest, 1);
    EXPECT_TRUE(std::isinf(scene.parameter("light.emission").highest));
    EXPECT_EQ(scene.parameters().size(), scene.select("*").size());
    EXPECT_EQ(scene.cameras().front().name, "front");

    std::vector<float> values = scene.values(kPainting);
    ASSERT_EQ(values.size(), info.entries());
    std::reverse(values.begin(), values.end());
    const Scene before = scene.copy();
    scene.set(kPainting, values);
    EXPECT_EQ(scene.values(kPainting), values);
    EXPECT_NE(before.values(kPainting), values);
    scene.set(kPainting, std::vector{0.1f, 0.2f, 0.3f});
    EXPECT_EQ(scene.values(kPainting)[4], 0.2f);
}

TEST(LibraryScene, ErrorsCarryKindCauseAndRemedy) {
    Scene scene = Scene::load(kBox);
    const Error unknown = errorOf([&] { scene.values("paintin.baseColor"); });
    EXPECT_EQ(unknown.kind, ErrorKind::Usage);
    EXPECT_NE(unknown.cause.find(kPainting), std::string::npos) << unknown.cause;
    EXPECT_FALSE(unknown.remedy.empty());
    EXPECT_EQ(errorOf([&] { scene.set(kPainting, std::vector{1.5f}); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { scene.set(kPainting, std::vector<float>(7)); }).kind, ErrorKind::Usage);
    EXPECT_EQ(errorOf([&] { scene.exportTo("/proc/none"); }).kind, ErrorKind::Output);
    const Error missing = errorOf([] { Scene::load("/nowhere/scene.gltf"); });
    EXPECT_EQ(missing.kind, ErrorKind::Input);
    EXPECT_FALSE(missing.cause.empty());
    EXPECT_FALSE(missing.remedy.empty());
    const Error device = errorOf([] { Device("no such device"); });
    EXPECT_EQ(device.kind, ErrorKind::Device);
    EXPECT_EQ(device.options, std::vector<std::string>{"device"});
    const Error memory = errorOf([&] { Renderer(::device(), scene, {.paths = {.memory = 1}}); });
    EXPECT_EQ(memory.options, std::vector<std::string>{"memory"});
    for (const Error& error : {unknown, missing, device, memory}) // which are the command line's
        EXPECT_EQ((error.what() + error.cause + error.remedy).find("--"), std::string::npos) << error.remedy;
}

TEST(LibraryScene, ExportsWhatWasSet) {
    const Folder folder;
    greyScene().exportTo(folder / "out");
    EXPECT_EQ(loadImage(folder / "out/parameters/painting.baseColor.exr").values, std::vector<float>(64 * 64 * 3, 0.5f));
    for (const float value : Scene::load(folder / "out/scene.gltf").values(kPainting))
        ASSERT_NEAR(value, 0.5f, 0.003f);
}

TEST(LibraryRenderer, FiltersAsTheProgramDoes) {
    const Folder folder;
    ASSERT_TRUE(program("render " + kBox + " --width 24 --spp 4 --filter tent:1.5 -o " + (folder / "tent.exr")));
    const auto render = [](const SceneOptions& options) { return Renderer(device(), Scene::load(kBox, options)).render({.width = 24, .spp = 4}).values; };
    const std::vector<float> tent = render({.filter = ReconstructionFilter{ReconstructionFilter::Kind::Tent, 1.5}});
    EXPECT_EQ(tent, loadImage(folder / "tent.exr").values);
    EXPECT_NE(tent, render({}));
    EXPECT_EQ(render({.filter = ReconstructionFilter{}}), render({})) << "glTF has a box";
    const Error error = errorOf([] { Scene::load(kBox, {.filter = ReconstructionFilter{ReconstructionFilter::Kind::Gaussian, 9}}); });
    EXPECT_EQ(error.kind, ErrorKind::Usage);
    EXPECT_EQ(error.options, std::vector<std::string>{"filter"});
}

TEST(LibraryRenderer, MakesTheImagesOfTheProgram) {
    const Folder folder;
    ASSERT_TRUE(program("render " + kBox + " --width 24 --spp 4 --seed 3 -o " + (folder / "plain.exr")));
    ASSERT_TRUE(program("render " + kBox + " --width 24 --spp 4 --train 2 --camera corner --set " + kPainting + "=0.5 -o " +
                        (folder / "guided.exr")));
    Scene scene = Scene::load(kBox);
    Renderer renderer(device(), scene);
    EXPECT_EQ(renderer.render({.width = 24, .spp = 4, .seed = 3}).values, loadImage(folder / "plain.exr").values);
    scene.set(kPainting, std::vector{0.5f}); // which the renderer was not told of
    EXPECT_EQ(renderer.render({.camera = "corner", .width = 24, .spp = 4, .train = 2}).values, loadImage(folder / "guided.exr").values);
}

TEST(LibraryRenderer, MakesTheDerivativesOfTheProgram) {
    const Folder folder;
    const std::string common = "gradient " + kBox + " --param " + kPainting + " --set " + kPainting + "=0.5 --spp-gradient 4 --train 2 ";
    const Image adjoint = Renderer(device(), Scene::load(kBox)).render({.width = 24, .spp = 4});
    saveImage(folder / "adjoint.exr", adjoint);
    ASSERT_TRUE(program(common + "--width 24 -o " + (folder / "forward.exr")));
    ASSERT_TRUE(program(common + "--adjoint " + (folder / "adjoint.exr") + " -o " + (folder / "backward.exr")));

    Renderer renderer(device(), greyScene(), {.paths = {}, .parameters = {"painting.*Color"}});
    ASSERT_EQ(renderer.parameters().size(), 1u);
    const std::vector<Direction> one{{kPainting, std::vector<float>(renderer.parameters()[0].entries(), 1.f)}};
    EXPECT_EQ(renderer.forward(one, {.width = 24, .spp = 4, .train = 2}).values, loadImage(folder / "forward.exr").values);
    const auto gradients = renderer.backward(adjoint, {.spp = 4, .train = 2});
    ASSERT_EQ(gradients.size(), 1u);
    EXPECT_EQ(std::vector<float>(gradients[0].begin(), gradients[0].end()), loadImage(folder / "backward.exr").values);
}

TEST(LibraryRenderer, FrozenDerivativesAreThoseOfTheImage) {
    Scene scene = Scene::load(kBox);
    Renderer renderer(device(), scene, {.paths = {.maxDepth = 3}, .parameters = {"light.emission"}});
    const PassOptions pass{.width = 16, .spp = 4, .seed = 5, .frozen = true};
    const std::vector<float> emission = scene.values("light.emission");
    const Image derivative = renderer.forward(std::vector{Direction{"light.emission", emission}}, pass);
    const Image image = renderer.render(pass);
    scene.set("light.emission", std::vector{2 * emission[0], 2 * emission[1], 2 * emission[2]});
    const Image twice = renderer.render(pass);
    double largest = 0;
    for (std::size_t i = 0; i < image.values.size(); ++i) {
        ASSERT_NEAR(derivative.values[i], twice.values[i] - image.values[i], 1e-4 * (1 + std::abs(image.values[i])));
        largest = std::max(largest, double(image.values[i]));
    }
    EXPECT_GT(largest, 0);
    EXPECT_EQ(errorOf([&] { renderer.render({.train = 1, .frozen = true}); }).kind, ErrorKind::Usage);
}

TEST(LibraryRenderer, SaysWhereSumsOverflow) {
    Scene scene = Scene::load(CMPG_SOURCE_DIR "/scenes/furnace/scene.gltf");
    Renderer renderer(device(), scene);
    const PassOptions pass{.width = 16, .height = 16, .spp = 4};
    renderer.render(pass);
    scene.set("wall.emission", std::vector{3e38f});
    const Error error = errorOf([&] { renderer.render(pass); });
    EXPECT_EQ(error.kind, ErrorKind::Numerical);
    EXPECT_FALSE(error.remedy.empty());
}

TEST(LibraryRenderer, SamplesUntilTheErrorIsSmallEnough) {
    Renderer renderer(device(), Scene::load(kBox), {.paths = {.maxDepth = 4}, .parameters = {kPainting}});
    PassReport report;
    const Image image = renderer.render({.width = 32, .errorTarget = 0.03}, &report);
    EXPECT_EQ(report.end, BudgetEnd::Error);
    EXPECT_EQ(report.batches, kFewestBatches);
    EXPECT_LE(report.error.relative, 0.03);
    EXPECT_GT(report.error.relative, 0.01); // no stage more than it takes
    EXPECT_LT(report.error.low, report.error.high);
    EXPECT_EQ(report.paths, std::uint64_t(report.spp) * image.pixels());
    // The same samples in as many batches are the same image.
    PassReport again;
    EXPECT_EQ(renderer.render({.width = 32, .spp = report.spp, .batches = kFewestBatches}, &again).values, image.values);
    EXPECT_EQ(again.error.relative, report.error.relative);
    EXPECT_EQ(again.end, BudgetEnd::Samples);

    renderer.backward(Image(32, 24, 3, 1.f), {.spp = 16, .errorTarget = 1e-6}, &report);
    EXPECT_EQ(report.end, BudgetEnd::Samples);
    EXPECT_EQ(report.spp, 16u);
    renderer.render({.width = 32, .timeBudget = 0.3}, &report);
    EXPECT_EQ(report.end, BudgetEnd::Time);
    EXPECT_EQ(errorOf([&] { renderer.render({.spp = 12, .batches = 8}); }).options, std::vector<std::string>{"spp"});
    EXPECT_EQ(errorOf([&] { renderer.render({.batches = 8, .layers = true}); }).kind, ErrorKind::Usage);
}

TEST(LibraryRenderer, GuidesAreSavedAndLoaded) {
    const Folder folder;
    const Scene scene = Scene::load(kBox);
    const Image adjoint(24, 18, 3, 1.f);
    RendererOptions options{.paths = {.maxDepth = 4, .sampling = Sampling::Conditional}, .parameters = {kPainting}};
    Renderer learner(device(), scene, options);
    EXPECT_EQ(errorOf([&] { learner.saveGuide(folder / "guide"); }).options, std::vector<std::string>{"train"});
    const auto learned = learner.backward(adjoint, {.spp = 8, .train = 2});
    learner.saveGuide(folder / "guide");
    options.paths.guide.load = folder / "guide";
    Renderer loaded(device(), scene, options);
    PassReport report;
    EXPECT_EQ(loaded.backward(adjoint, {.spp = 8}, &report), learned);
    EXPECT_TRUE(report.guided);
    EXPECT_EQ(report.sampling, Sampling::Conditional);
    EXPECT_NE(learner.backward(adjoint, {.spp = 8, .seed = 1}), learned);

    // Learning goes on from what this renderer knows as it does from a file, or begins anew.
    const PassOptions further{.spp = 8, .seed = 2, .train = 1, .anew = false};
    const auto continued = learner.backward(adjoint, further);
    EXPECT_EQ(continued, loaded.backward(adjoint, further));
    const PassOptions again{.spp = 8, .seed = 2, .train = 1};
    RendererOptions without = options;
    without.paths.guide.load.clear();
    const auto fresh = Renderer(device(), scene, without).backward(adjoint, again);
    EXPECT_NE(fresh, continued);
    EXPECT_EQ(learner.backward(adjoint, again), fresh);

    options.parameters = {"light.emission"};
    const Error other = errorOf([&] { Renderer(device(), scene, options).backward(adjoint, {.spp = 8}); });
    EXPECT_EQ(other.kind, ErrorKind::Input);
    EXPECT_NE(other.cause.find(kPainting), std::string::npos) << other.cause;
    options.paths.guide.load = folder / "none";
    EXPECT_EQ(errorOf([&] { Renderer(device(), scene, options).backward(adjoint, {.spp = 8}); }).kind, ErrorKind::Input);
}

TEST(LibraryRenderer, ChecksItsDerivatives) {
    Renderer renderer(device(), Scene::load(kBox), {.paths = {.maxDepth = 2}, .parameters = {kPainting}});
    const Direction one{kPainting, std::vector<float>(64 * 64 * 3, 1.f)};
    const CheckResult result = renderer.check(one, {.width = 24, .spp = 4});
    EXPECT_TRUE(result.agrees());
    EXPECT_EQ(result.comparisons.front().what, "red mean");
    EXPECT_LT(std::abs(result.comparisons.front().relativeError()), 0.1);
    const PassOptions pass{.width = 24, .spp = 4};
    EXPECT_EQ(renderer.render(pass).values, Renderer(device(), Scene::load(kBox), {.paths = {.maxDepth = 2}, .parameters = {kPainting}}).render(pass).values);
}

TEST(LibraryRenderer, TellsLayersAndShowsImagesAsTheyGrow) {
    Renderer renderer(device(), Scene::load(kBox), {.paths = {.maxDepth = 3}});
    PassReport report;
    std::vector<Image> shown;
    const PassOptions pass{.width = 24, .spp = 8};
    PassOptions growing = pass;
    growing.layers = true;
    growing.onImage = [&](const Image& image) { shown.push_back(image); };
    const Image image = renderer.render(growing, &report);
    ASSERT_GE(shown.size(), 2u);
    EXPECT_EQ(shown.back().values, image.values);
    EXPECT_EQ(renderer.render(pass).values, image.values);
    EXPECT_EQ(report.layers.depth.width, 24);
    EXPECT_EQ(report.layers.samples.values.front(), 8);
    EXPECT_GT(report.layers.depth.values.front(), 0);
    EXPECT_FALSE(report.guided);
    EXPECT_EQ(report.paths, 8 * image.pixels());
    EXPECT_GT(report.seconds, 0);
}

TEST(LibraryRenderer, EndsAPassWhenAskedTo) {
    Renderer renderer(device(), Scene::load(kBox));
    const PassOptions pass{.width = 24, .spp = 4, .train = 1};
    const Image image = renderer.render(pass);
    struct Ended {};
    renderer.onSubmission([] { throw Ended{}; });
    EXPECT_THROW(renderer.render(pass), Ended);
    renderer.onSubmission({});
    EXPECT_EQ(renderer.render(pass).values, image.values);
}

TEST(LibraryRenderer, RendersTwoScenesAtOnce) {
    const Scene a = Scene::load(kBox), b = Scene::load(CMPG_SOURCE_DIR "/scenes/furnace/scene.gltf");
    const PassOptions pass{.width = 16, .spp = 2};
    const Image first = Renderer(device(), a).render(pass), second = Renderer(device(), b).render(pass);
    bool same = true;
    std::thread other([&] {
        for (int i = 0; i < 5; ++i)
            same &= Renderer(device(), b).render(pass).values == second.values;
    });
    for (int i = 0; i < 5; ++i)
        EXPECT_EQ(Renderer(device(), a).render(pass).values, first.values);
    other.join();
    EXPECT_TRUE(same);
}

// What each of `count` ranks, threads with devices of their own, makes of a device.
template <class Make> auto onRanks(int count, Make&& make) {
    test::ThreadRank::Table table(count);
    std::vector<decltype(make(std::declval<Device&>()))> results(static_cast<std::size_t>(count));
    std::vector<std::thread> threads;
    for (int r = 0; r < count; ++r)
        threads.emplace_back([&, r] {
            Device shared({}, std::make_shared<test::ThreadRank>(table, r));
            results[std::size_t(r)] = make(shared);
        });
    for (std::thread& thread : threads)
        thread.join();
    return results;
}

TEST(LibraryRanks, ShareWhatOneMakes) {
    const Target target = smallTarget();
    const auto work = [&](Device& on) {
        Renderer renderer(on, greyScene(), {.paths = {.maxDepth = 4}, .parameters = {kPainting}});
        std::vector<std::vector<double>> found = renderer.backward(target.image, {.spp = 8, .train = 1});
        PassOptions pass{.width = 40, .spp = 4};
        std::size_t shown = 0;
        pass.onImage = [&](const Image&) { ++shown; };
        const Image image = renderer.render(pass);
        EXPECT_GE(shown, 1u);
        found.emplace_back(image.values.begin(), image.values.end());
        Recovery recovery(on, greyScene(), {target}, paintingOptions());
        found.push_back({recovery.step().loss, recovery.step().loss});
        const std::vector<float> values = recovery.values(kPainting);
        found.emplace_back(values.begin(), values.end());
        return found;
    };
    const auto alone = work(device());
    for (const auto& found : onRanks(2, work))
        EXPECT_EQ(found, alone);
}

TEST(LibraryRanks, RefuseToShareDifferentThings) {
    const auto refused = onRanks(2, [](Device& on) {
        static std::atomic<int> number;
        const float mine = 0.1f * float(++number);
        std::vector<std::string> errors;
        const auto attempt = [&](auto&& call) {
            try {
                call();
            } catch (const Error& error) {
                EXPECT_EQ(error.kind, ErrorKind::Usage);
                errors.push_back(error.what());
            }
        };
        Scene scene = greyScene();
        Renderer renderer(on, scene, {.parameters = {kPainting}});
        const Image image = renderer.render({.width = 8, .spp = 1});
        attempt([&] { renderer.render({.width = 8, .timeBudget = 1}); });
        scene.set(kPainting, std::vector{mine});
        attempt([&] { renderer.render({.width = 8, .spp = 1}); });
        attempt([&] { Recovery(on, scene, {{"", image}}, paintingOptions()); });
        return errors;
    });
    for (const std::vector<std::string>& errors : refused)
        EXPECT_EQ(errors, (std::vector<std::string>{"a time budget does not run on several ranks", "rank 1 has asked for another pass than rank 0",
                                                    "rank 1 recovers something else than rank 0"}));
}

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
    Recovery recovery(device(), scene, {smallTarget()}, options);
    std::vector<double> losses;
    while (!recovery.done())
        losses.push_back(recovery.step().loss);
    ASSERT_EQ(losses.size(), 6u);
    EXPECT_LT(losses.back(), 0.5 * losses.front());
    recovery.apply(scene);
    EXPECT_EQ(scene.values(kPainting), recovery.values(kPainting));
}

TEST(LibraryRecovery, GoesOnFromACheckpointToTheSameBits) {
    const Folder folder;
    const Scene scene = greyScene();
    const std::vector<Target> targets{smallTarget()};
    Recovery whole(device(), scene, targets, paintingOptions()), half(device(), scene, targets, paintingOptions());
    for (int i = 0; i < 4; ++i)
        whole.step();
    for (int i = 0; i < 2; ++i)
        half.step();
    EXPECT_GT(half.save(folder / "kept"), 64u * 64 * 3 * sizeof(float));
    Recovery resumed(device(), scene, targets, paintingOptions());
    EXPECT_FALSE(resumed.resume(folder / "none"));
    std::vector<Warning> warnings;
    ASSERT_TRUE(resumed.resume(folder / "kept", &warnings));
    EXPECT_TRUE(warnings.empty()) << warnings.front().text;
    EXPECT_EQ(resumed.steps(), 2u);
    ASSERT_EQ(resumed.history().size(), 2u);
    for (int i = 0; i < 2; ++i)
        resumed.step();
    EXPECT_EQ(resumed.values(kPainting), whole.values(kPainting));
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_EQ(resumed.history().at(i).loss, whole.history().at(i).loss);

    RecoveryOptions others = paintingOptions();
    others.sppGradient = 8;
    Recovery other(device(), scene, targets, others);
    const Error error = errorOf([&] { other.resume(folder / "kept"); });
    EXPECT_EQ(error.kind, ErrorKind::Usage);
    EXPECT_NE(std::string(error.what()).find("spp-gradient differs: it has 4, this one 8"), std::string::npos) << error.what();
    EXPECT_EQ(error.options, (std::vector<std::string>{"spp-gradient", "resume"}));
    Recovery beside(device(), scene, {smallTarget(2)}, paintingOptions());
    const Error of = errorOf([&] { beside.resume(folder / "kept"); });
    EXPECT_EQ(of.kind, ErrorKind::Input);
    EXPECT_NE(std::string(of.what()).find("the target differs"), std::string::npos) << of.what();
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

// Images and gradient images of a session are those of the headless commands; settings may change at any time.
#include "live/live_worker.h"
#include "live_fixture.h"
#include "scene/scene_file.h"

#include "library/states.h"
#include "render/guided_passes.h"
#include "session/library_options.h"
#include "session/parameter_values.h"
#include "session/output.h"
#include "session/session.h"
#include "support/environment.h"

#include <cmath>
#include <fstream>
#include <optional>

namespace cmpg::test {
namespace {

struct Headless {
    Options options;
    Device device{Device::Options{}};
    Scene scene = loadScene(options.input);
    View view;

    explicit Headless(const Options& o) : options(o) {
        view = {&scene.cameras.front(), int(*options.width), int(*options.height)};
    }
    Renderer renderer(const std::vector<std::uint32_t>& parameters) {
        RenderConfig config = v1::renderConfig(pathOptions(options, options.effectiveDepth(scene.maxDepth)), scene, parameters);
        config.guiding = usesGuide(options);
        return Renderer(device, scene, config);
    }
};

TEST(LiveRefine, TheImageIsThatOfRender) {
    Options options = liveOptions("box");
    options.spp = 37;
    Watched live(options);
    const auto state = live.untilRefined();
    EXPECT_EQ(state->imageSamples, 37u);
    EXPECT_FALSE(state->preview);
    Headless headless(options);
    Renderer renderer = headless.renderer({});
    EXPECT_EQ(state->picture(LivePicture::Image)->values, renderer.render(headless.view, 37, {.seed = options.seed}).values);
    EXPECT_EQ(state->error.number, 0u) << state->error.what;
}

TEST(LiveRefine, AnImageNeedsNoParameter) {
    Options options = liveOptions("box", 48);
    options.spp = 1024; // several passes
    Watched live(options);
    live.until([](const LiveState& s) { return s.scene != nullptr; }, "the scene");
    live->change([](LiveSettings& s) { s.parameters = {}; });
    live.until([](const LiveState& s) { return s.settings.parameters.empty() && s.imageSamples == 1024 && !s.refining; }, "the end of refinement");
}

// While the picture made in haste of one view is drawn, the view moves on: no pass of the full size is spent on the first.
TEST(LiveRefine, AViewThatMovesInAPreviewIsFollowedAtOnce) {
    Watched live(liveOptions("box", 64));
    const auto first = live.until([](const LiveState& s) { return s.imageSamples >= 64; }, "64 samples");
    const int edge = int(std::sqrt(2 * first->samplesPerSecond)); // a pass takes seconds, a preview hardly any time
    if (edge > 4096)
        GTEST_SKIP() << "the device is too fast for pictures of a size that fits into memory";
    live->change([&](LiveSettings& s) { s.width = s.height = edge; });
    live.until([&](const LiveState& s) { return s.settings.width == edge && s.preview; }, "a preview");
    float place = first->settings.camera.toWorld[12];
    for (int i = 0; i < 12; ++i) {
        const auto move = [&] {
            place += 0.001f;
            live->change([&](LiveSettings& s) { s.camera.toWorld[12] = place; });
        };
        move();
        std::this_thread::sleep_for(std::chrono::milliseconds(6 * i));
        move();
        bool whole = false;
        live.until(
            [&](const LiveState& s) {
                whole = whole || (s.imageSamples > 0 && s.settings.width == edge);
                return s.preview && s.settings.camera.toWorld[12] == place;
            },
            "a preview of the last view");
        ASSERT_FALSE(whole) << "moved again after " << 6 * i << " ms";
    }
}

TEST(LiveRefine, TheGradientIsThatOfGradient) {
    Options options = liveOptions("box");
    options.command = Command::Gradient;
    options.param = {"painting.baseColor", "white.baseColor"};
    options.spp = 11;
    Watched live(options);
    const auto state = live.until([](const LiveState& s) { return s.gradientSamples == 11 && s.imageSamples == 11; }, "11 samples");
    Headless headless(options);
    const std::vector<std::uint32_t> parameters = selectParameters(headless.scene, options.param);
    EXPECT_EQ(state->settings.parameters, parameters);
    Renderer renderer = headless.renderer(parameters);
    std::vector<std::vector<float>> ones;
    for (const std::uint32_t p : parameters)
        ones.emplace_back(headless.scene.parameters[p].entries(), 1.f);
    const Image gradient = renderer.forward(headless.view, 11, {.seed = options.seed, .pass = 1}, parameters, ones);
    EXPECT_EQ(state->picture(LivePicture::Gradient)->values, gradient.values);
}

TEST(LiveRefine, TrainingIsThatOfGradientWithTrain) {
    Options options = liveOptions("door");
    options.command = Command::Gradient;
    options.param = {"painting.baseColor"};
    options.spp = 8;
    options.train = 3;
    Watched live(options);
    live->train(2);
    live->train(1);
    const auto state = live.until([](const LiveState& s) { return s.guidePasses == 3 && s.gradientSamples == 8; }, "a trained gradient");
    EXPECT_TRUE(state->guideLearned);
    EXPECT_GT(state->guideCells, 0u);
    Headless headless(options);
    const std::vector<std::uint32_t> parameters = selectParameters(headless.scene, options.param);
    Renderer renderer = headless.renderer(parameters);
    GuidedPasses passes(renderer, {});
    const std::vector<std::vector<float>> ones{std::vector<float>(headless.scene.parameters[parameters[0]].entries(), 1.f)};
    passes.trainForward(headless.view, 8, 3, options.seed, parameters, ones);
    const Image gradient = passes.forward(headless.view, 8, {.seed = options.seed, .pass = 1}, parameters, ones);
    EXPECT_EQ(state->picture(LivePicture::Gradient)->values, gradient.values);
    EXPECT_EQ(state->sampling, passes.decision().method.kind);
}

TEST(LiveRefine, AStormOfSettingsEndsWithTheLastOne) {
    Options options = liveOptions("box");
    options.spp = 4;
    Watched live(options);
    live.until([](const LiveState& s) { return s.imageSamples > 0; }, "an image");
    for (int i = 0; i < 200; ++i)
        live->change([&](LiveSettings& s) {
            s.camera.toWorld[12] += 0.001f;
            s.width = 16 + i % 9;
            s.mode = i % 3 == 0 ? LiveMode::Gradient : LiveMode::Render;
            s.layers = i % 2 == 0;
            s.running = i % 5 != 0;
        });
    live->change([](LiveSettings& s) {
        s.mode = LiveMode::Render;
        s.width = 20;
        s.running = true;
        s.layers = true;
    });
    const auto state = live.until(
        [](const LiveState& s) { return s.settings.width == 20 && s.settings.layers && s.imageSamples == 4 && !s.refining; }, "the last settings");
    EXPECT_EQ(state->picture(LivePicture::Image)->width, 20);
    EXPECT_EQ(state->picture(LivePicture::Depth)->width, 20);
    Headless headless(options);
    Renderer renderer = headless.renderer({});
    Camera moved = headless.scene.cameras.front();
    moved.toWorld[3].x = state->settings.camera.toWorld[12];
    headless.view.camera = &moved;
    headless.view.width = 20;
    Layers layers;
    EXPECT_EQ(state->picture(LivePicture::Image)->values, renderer.render(headless.view, 4, {.seed = options.seed}, {}, nullptr, &layers).values);
    EXPECT_EQ(state->picture(LivePicture::Albedo)->values, layers.albedo.values);
    EXPECT_EQ(state->error.number, 0u) << state->error.what;
}

TEST(LiveRefine, NonsenseIsBroughtIntoRange) {
    Options options = liveOptions("box");
    options.spp = 1;
    Watched live(options);
    live.untilRefined();
    live->change([](LiveSettings& s) {
        s.width = -5;
        s.camera.yfov = std::nanf("");
        s.camera.toWorld[13] = INFINITY;
        s.parameters = {0, 0, 100000};
        s.rateFactor = std::nanf("");
        s.sppLimit = 0;
        s.view = 77;
    });
    const auto state = live.until([](const LiveState& s) { return s.settings.width == 1 && !s.refining; }, "a pixel");
    EXPECT_EQ(state->settings.parameters, std::vector<std::uint32_t>{0});
    EXPECT_EQ(state->settings.view, 0u);
    EXPECT_EQ(state->picture(LivePicture::Image)->width, 1);
    EXPECT_EQ(state->error.number, 0u) << state->error.what;
}

TEST(LiveRefine, MistakesAreReportedAndSurvived) {
    const TempFolder scratch;
    Options options = liveOptions("box");
    options.spp = 2;
    options.target = {(scratch / "missing.exr").string()};
    Watched live(options);
    auto state = live.untilError(1);
    EXPECT_NE(state->error.what.find("missing.exr"), std::string::npos);
    EXPECT_FALSE(state->dead);
    live.untilRefined();
    live->openScene(scratch / "missing.gltf");
    state = live.untilError(2);
    EXPECT_NE(state->error.what.find("missing.gltf"), std::string::npos);
    EXPECT_EQ(state->scene->number, 1u);
    live->openTarget((scratch / "nothing.png").string());
    live.untilError(3);
    live->openScene(sceneFile("door"));
    state = live.until([](const LiveState& s) { return s.scene->number == 2 && s.imageSamples == 2; }, "the other scene");
    EXPECT_NE(state->scene->file.find("door"), std::string::npos);
    EXPECT_FALSE(state->settings.parameters.empty());
    EXPECT_EQ(state->error.what, ""); // what was wrong before is settled
    live->openTarget((scratch / "nothing.png").string());
    EXPECT_NE(live.untilError(4)->error.what, "");
    live->openTarget(CMPG_SOURCE_DIR "/scenes/door/target.exr");
    live.until([](const LiveState& s) { return s.error.number == 4 && s.error.what.empty(); }, "a target that opens");
    // But not that a file could not be written.
    live->save(LivePicture::Image, scratch / "image.txt");
    live->openScene(sceneFile("box"));
    state = live.until([](const LiveState& s) { return s.scene->number == 3 && s.imageSamples == 2; }, "a third scene");
    EXPECT_EQ(state->error.number, 5u);
    EXPECT_NE(state->error.what.find("image.txt"), std::string::npos) << state->error.what;
}

TEST(LiveRefine, ATargetBelongsToTheSceneItWasAskedForWith) {
    const std::string own = CMPG_SOURCE_DIR "/scenes/door/target.exr", other = CMPG_SOURCE_DIR "/scenes/bowl/target.exr";
    Options options = liveOptions("box");
    options.spp = 1;
    Watched live(options);
    live.untilRefined();
    const auto opened = [&](std::uint32_t number, const std::string& target) {
        const auto state = live.until([&](const LiveState& s) { return s.scene->number == number && s.views == 1 && s.targets[0] == target; }, "scene and target");
        EXPECT_EQ(state->error.number, 0u) << state->error.what;
    };
    live->openScene(sceneFile("door"), other);
    opened(2, other);
    live->openScene(sceneFile("door"));
    live->openTarget(other); // whether or not the scene is there by then
    opened(3, other);
    live->openTarget(other); // of the scene before
    live->openScene(sceneFile("door"));
    live.until([&](const LiveState& s) { return s.scene->number == 4 && s.imageSamples > 0; }, "the scene alone");
    opened(4, own);
    // A scene that does not open takes its target along.
    live->openScene("nowhere.gltf", other);
    EXPECT_EQ(live.untilError(1)->targets, std::vector{own});
    live->train();
    EXPECT_EQ(live.until([](const LiveState& s) { return s.guidePasses == 1; }, "a pass")->targets, std::vector{own});
}

TEST(LiveRefine, ASceneTellsWhatItLacks) {
    const TempFolder scratch;
    std::ofstream(scratch / "empty.gltf") << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{}]})";
    Options options = liveOptions("box");
    options.input = (scratch / "empty.gltf").string();
    options.spp = 1;
    Watched live(options);
    const auto state = live.untilRefined();
    const auto warns = [&](const char* of) {
        return std::any_of(state->scene->warnings.begin(), state->scene->warnings.end(), [&](const std::string& w) { return w.find(of) != std::string::npos; });
    };
    EXPECT_TRUE(warns("no triangles"));
    EXPECT_TRUE(warns("no light"));
}

// A mask is of a camera of the scene that it was given with.
TEST(LiveRefine, MasksEndWithTheirScene) {
    Options options = liveOptions("box");
    options.spp = 2;
    options.mask = {"corner=" + std::string(CMPG_SOURCE_DIR "/scenes/box/target.exr")};
    Watched live(options);
    EXPECT_NE(live.untilError(1)->error.what.find("corner"), std::string::npos); // there is no target of it
    live->openScene(sceneFile("door"));
    live.until([](const LiveState& s) { return s.scene->number == 2 && s.imageSamples == 2; }, "the other scene");
    live->change([](LiveSettings& s) { s.mode = LiveMode::Optimize; });
    live->stepOnce();
    const auto state = live.until([](const LiveState& s) { return s.step == 1; }, "a step towards its target");
    EXPECT_EQ(state->error.number, 1u) << state->error.what;
}

// The scene that was open has no device any more when another one cannot be read.
TEST(LiveRefine, ASceneThatCannotBeReadAfterADeviceWasLost) {
    const TempFolder scratch;
    Options options = liveOptions("box", 64);
    std::optional<const Environment> fault(std::in_place, "CMPG_FAULT", "lost:3");
    Watched live(options);
    live.untilError(1);
    live->openScene(scratch / "missing.gltf");
    auto state = live.untilError(2);
    EXPECT_NE(state->error.what.find("missing.gltf"), std::string::npos) << state->error.what;
    fault.reset();
    live->openScene(sceneFile("box"));
    live.until([](const LiveState& s) { return s.scene->number == 2 && s.imageSamples > 0; }, "an image");
}

TEST(LiveRefine, WithoutASceneThereIsNothingButAMessage) {
    Options options = liveOptions("box");
    options.input = "nowhere.gltf";
    Watched live(options);
    const auto state = live.until([](const LiveState& s) { return s.dead && s.error.number == 1; }, "the end");
    EXPECT_NE(state->notice.find("drop a scene"), std::string::npos);
    live->pick(1, 1);
    live->reset();
    live->save(LivePicture::Image, "nothing.exr");
    live.untilError(2);
    live->openTarget("target.exr");
    EXPECT_NE(live.untilError(3)->error.what.find("target.exr"), std::string::npos);
    live->openScene(sceneFile("box"));
    EXPECT_FALSE(live.until([](const LiveState& s) { return s.imageSamples > 0; }, "an image")->dead);
}

TEST(LiveRefine, ADeviceThatIsNoneIsReported) {
    Options options = liveOptions("box");
    options.device = "no such device";
    Watched live(options);
    const auto state = live.until([](const LiveState& s) { return s.dead; }, "the end");
    EXPECT_NE(state->error.what.find("no such device"), std::string::npos);
}

// The worker of a session without its front.
struct LoneWorker {
    explicit LoneWorker(const Options& options) : options_(options) {
        mailbox.ask([&](LiveRequests&, LiveSettings& wished) { wished = LiveWorker::settingsAtStart(options_); });
    }
    void run() { LiveWorker(options_, mailbox).run(); }

    LiveMailbox mailbox{{}};

  private:
    Options options_;
};

TEST(LiveRefine, EndsInTheMidstOfAPass) {
    LoneWorker worker(liveOptions("box", 32));
    std::thread thread([&] { worker.run(); });
    worker.mailbox.ask([](LiveRequests& r, LiveSettings& wished) {
        wished.spp = 1 << 16; // a minute's worth
        r.train = 1;
    });
    // A pick is answered before the pass begins or in it, one that is asked for then is answered in it.
    for (std::uint32_t number = 1; number <= 2; ++number) {
        worker.mailbox.ask([](LiveRequests& r, LiveSettings&) { r.pick = {16, 16}; });
        for (int i = 0; i < 24000 && !(worker.mailbox.state()->pick && worker.mailbox.state()->pick->number == number); ++i) // two minutes
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        EXPECT_TRUE(worker.mailbox.state()->pick);
    }
    worker.mailbox.ask([](LiveRequests& r, LiveSettings&) { r.quit = true; });
    thread.join();
    EXPECT_EQ(worker.mailbox.state()->guidePasses, 0u);
    EXPECT_EQ(worker.mailbox.state()->error.number, 0u) << worker.mailbox.state()->error.what;
}

TEST(LiveRefine, FilesAreWrittenBeforeTheEnd) {
    const TempFolder scratch;
    LoneWorker worker(liveOptions("box"));
    worker.mailbox.ask([&](LiveRequests& r, LiveSettings&) {
        r.saves.push_back({scratch / "a.txt", [&] { writeTextFile(scratch / "a.txt", "a"); }});
        r.sceneFolder = scratch / "saved";
        r.quit = true;
    });
    worker.run();
    EXPECT_TRUE(std::filesystem::exists(scratch / "a.txt"));
    EXPECT_TRUE(std::filesystem::exists(scratch / "saved/scene.gltf"));
    // Nor does another scene take their place.
    Watched live(liveOptions("box"));
    live->saveScene(scratch / "before");
    live->openScene(sceneFile("door"));
    live.until([](const LiveState& s) { return s.scene && s.scene->number == 2; }, "the other scene");
    EXPECT_TRUE(std::filesystem::exists(scratch / "before/scene.gltf"));
}

} // namespace
} // namespace cmpg::test

// The optimisation of a session: the steps of the headless one, whatever is asked for between and during them.
#include "live_fixture.h"
#include "scene/scene_file.h"

#include "optimize/recovery_config.h"
#include "optimize/recovery_run.h"
#include "scene/image_decode.h"
#include "session/library_options.h"
#include "session/parameter_values.h"
#include "session/targets.h"

#include <cmath>
#include <fstream>

namespace cmpg::test {
namespace {

constexpr int kEdge = 24;

// The scene's own image is the target, the painting grey at first.
class LiveOptimize : public testing::Test {
  protected:
    TempFolder scratch_;
    Options options_;

    void SetUp() override {
        options_ = liveOptions("box", kEdge);
        options_.command = Command::Optimize;
        options_.param = {"painting.baseColor"};
        options_.set = {"painting.baseColor=0.5"};
        options_.spp = 4;
        options_.sppGradient = 2;
        options_.target = {(scratch_ / "target.exr").string()};
        Device device{Device::Options{}};
        Scene scene = loadScene(options_.input);
        RenderConfig config;
        config.maxDepth = *options_.maxDepth;
        Renderer renderer(device, scene, config);
        writeExr(options_.target[0], renderer.render({&scene.cameras.front(), kEdge, kEdge}, 64, {.seed = 99}));
    }

    std::vector<double> headlessLoss(std::uint32_t steps, std::vector<float>* values = nullptr) const {
        Device device{Device::Options{}};
        Scene scene = loadScene(options_.input);
        for (const std::string& s : options_.set)
            applySet(scene, s);
        const std::vector<std::uint32_t> parameters = selectParameters(scene, options_.param);
        RenderConfig render;
        render.differentiable = parameters;
        render.maxDepth = *options_.maxDepth;
        render.guiding = true;
        render.differences = options_.recovery.sppDifference > 0;
        Renderer renderer(device, scene, render);
        GuidedPasses passes(renderer, {.sampling = options_.sampling});
        passes.setLearning(true);
        OptimizeConfig config = configOf(recoveryOptions(options_, 0));
        config.targets = {loadTarget(options_.target[0])};
        RecoveryRun run(renderer, passes, scene, parameters, {.config = config, .views = {{&scene.cameras.front(), kEdge, kEdge}}});
        std::vector<double> loss;
        for (std::uint32_t i = 0; i < steps; ++i)
            loss.push_back(run.optimization().step().loss);
        if (values)
            *values = scene.parameters[parameters[0]].values;
        return loss;
    }

    // Paused from the start.
    std::unique_ptr<Watched> open(bool running = false) const {
        auto live = std::make_unique<Watched>(options_);
        (*live)->change([&](LiveSettings& s) { s.running = running; });
        return live;
    }
};

TEST_F(LiveOptimize, StepsAreThoseOfTheHeadlessRun) {
    const auto live = open();
    (*live)->stepOnce(3);
    (*live)->stepOnce();
    const auto state = live->until([](const LiveState& s) { return s.step == 4 && !s.refining; }, "4 steps");
    std::vector<float> values;
    EXPECT_EQ(*state->loss, headlessLoss(4, &values));
    EXPECT_EQ(state->picture(LivePicture::Parameter)->values, values);
    for (const LivePicture p : {LivePicture::Image, LivePicture::Target, LivePicture::Difference, LivePicture::Gradient, LivePicture::ParameterGradient})
        EXPECT_TRUE(state->picture(p)) << livePictureName(p);
    const std::vector<float>&image = state->picture(LivePicture::Image)->values, &target = state->picture(LivePicture::Target)->values;
    EXPECT_EQ(state->picture(LivePicture::Difference)->values[17], image[17] - target[17]);
    EXPECT_TRUE(state->guideLearned);
    EXPECT_GT(state->secondsPrimal, 0);
    EXPECT_GT(state->secondsGradient, 0);
    // Paused, both images are refined at the parameters as they are.
    EXPECT_FALSE(state->gradientFading);
    EXPECT_EQ(state->imageSamples, 4u); // --spp bounds it
    EXPECT_EQ(state->error.number, 0u) << state->error.what;
}

TEST_F(LiveOptimize, StepsThatAreInterruptedBeginAgain) {
    options_.spp = 64; // long enough to be met in their midst
    options_.sppGradient = 32;
    const std::vector<double> expected = headlessLoss(3);
    const auto live = open();
    (*live)->stepOnce(3);
    LiveSettings settings = (*live)->settings();
    for (int i = 0; i < 6; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(150));
        (*live)->change([&](LiveSettings& s) { s.mode = i % 2 == 0 ? LiveMode::Render : LiveMode::Optimize; });
    }
    const auto state = live->untilStep(3);
    EXPECT_EQ(*state->loss, expected);
}

TEST_F(LiveOptimize, PausesResetsAndGoesOn) {
    const auto live = open(true);
    live->untilStep(2);
    (*live)->change([](LiveSettings& s) { s.running = false; });
    const auto paused = live->until([](const LiveState& s) { return !s.settings.running && !s.refining; }, "the pause");
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    EXPECT_EQ((*live)->state()->step, paused->step);
    (*live)->reset();
    const auto fresh = live->until([](const LiveState& s) { return s.step == 0 && !s.loss; }, "the reset");
    for (const float v : fresh->picture(LivePicture::Parameter)->values)
        ASSERT_EQ(v, 0.5f);
    (*live)->stepOnce(2);
    EXPECT_EQ(*live->untilStep(2)->loss, headlessLoss(2)); // the guide has forgotten, too
    (*live)->fill(0.25f);
    const auto filled = live->until([](const LiveState& s) { return s.step == 0 && s.picture(LivePicture::Parameter)->values[0] == 0.25f; }, "the fill");
    EXPECT_EQ(filled->picture(LivePicture::Parameter)->values.back(), 0.25f);
    // Paused, the other modes draw nothing, and say so until they do.
    (*live)->change([](LiveSettings& s) { s.mode = LiveMode::Render; });
    live->until([](const LiveState& s) { return s.settings.mode == LiveMode::Render && s.notice.find("paused") == 0; }, "a notice");
    (*live)->change([](LiveSettings& s) { s.running = true; });
    EXPECT_EQ(live->until([](const LiveState& s) { return s.imageSamples == 4 && !s.refining; }, "an image")->notice, "");
}

TEST_F(LiveOptimize, APauseLosesNothingOfTheImage) {
    options_.spp = 1;
    const auto live = open();
    const auto image = [](const auto& state) { return state->picture(LivePicture::Image); };
    (*live)->stepOnce(40);
    const auto last = live->until([](const LiveState& s) { return s.step == 40; }, "40 steps");
    // Refined up to --spp it would be noisier.
    const auto paused = live->until([](const LiveState& s) { return !s.refining; }, "the end of refinement");
    EXPECT_TRUE(paused->imageCarried);
    EXPECT_EQ(image(paused), image(last));
    EXPECT_EQ(paused->picture(LivePicture::Difference), last->picture(LivePicture::Difference));
    (*live)->change([](LiveSettings& s) { s.layers = true; }); // the films begin anew
    const auto layers = live->until([](const LiveState& s) { return s.settings.layers && s.picture(LivePicture::Normal) && !s.refining; }, "layers");
    EXPECT_EQ(image(layers), image(last));
    // The first that takes its place has less noise.
    (*live)->change([](LiveSettings& s) { s.sppLimit = 2048; });
    const auto refined = live->until([](const LiveState& s) { return !s.imageCarried; }, "a refined image");
    const auto clean = live->until([](const LiveState& s) { return s.imageSamples == 2048; }, "a clean image");
    EXPECT_NE(clean->picture(LivePicture::Difference), last->picture(LivePicture::Difference));
    const auto noise = [&](const auto& state) {
        double sum = 0;
        for (std::size_t i = 0; i < image(clean)->values.size(); ++i)
            sum += std::pow(double(image(state)->values[i]) - double(image(clean)->values[i]), 2);
        return sum;
    };
    EXPECT_LT(noise(refined), noise(last));
}

TEST_F(LiveOptimize, ChangesOfMindTakeEffectInMidRun) {
    const auto live = open(true);
    live->untilStep(2);
    (*live)->change([](LiveSettings& s) { s.rateFactor = 0; });
    live->until([](const LiveState& s) { return s.settings.rateFactor == 0 && s.rate == 0; }, "a rate of 0");
    const auto still = (*live)->state();
    const auto later = live->untilStep(still->step + 2);
    EXPECT_EQ(later->picture(LivePicture::Parameter)->values, still->picture(LivePicture::Parameter)->values);

    (*live)->change([](LiveSettings& s) {
        s.rateFactor = 2;
        s.sampling = Sampling::Conditional;
    });
    const auto conditional = live->until([](const LiveState& s) { return s.settings.sampling == Sampling::Conditional && s.rate > 0; }, "another way");
    EXPECT_NEAR(conditional->rate, 2 * 0.02, 1e-6); // Adam's
    const std::uint32_t step = conditional->step;
    const auto guided = live->untilStep(step + 2);
    EXPECT_EQ(guided->sampling, Sampling::Conditional);
    EXPECT_GT(guided->guidedShare, 0);

    // Another parameter: the values of the first stay, steps go on counting, the new one moves.
    const auto scene = guided->scene;
    std::uint32_t white = 0;
    while (scene->parameters[white].name != "white.baseColor")
        ++white;
    (*live)->change([&](LiveSettings& s) { s.parameters = {white}; });
    const auto other = live->until(
        [&](const LiveState& s) { return s.settings.parameters == std::vector{white} && s.picture(LivePicture::ParameterGradient) && s.step > step + 3; },
        "a step of the other parameter");
    EXPECT_EQ(other->picture(LivePicture::Parameter)->values.size(), 3u);
    EXPECT_EQ(other->loss->size(), other->step);
    EXPECT_EQ(other->error.number, 0u) << other->error.what;
    // The first one again: it is where it was left, off its first values.
    (*live)->change([&](LiveSettings& s) {
        s.parameters = guided->settings.parameters;
        s.running = false;
    });
    const auto first = live->until([&](const LiveState& s) { return s.settings.parameters == guided->settings.parameters && !s.refining; }, "the first parameter");
    EXPECT_NE(first->picture(LivePicture::Parameter)->values, std::vector<float>(first->picture(LivePicture::Parameter)->values.size(), 0.5f));
}

TEST_F(LiveOptimize, AnImageBecomesTheTarget) {
    options_.target.clear();
    options_.set.clear();
    options_.param.clear(); // the first textured parameter
    const auto live = open();
    EXPECT_NE(live->until([](const LiveState& s) { return s.views == 1; }, "the target beside the scene")->targets[0].find("box"), std::string::npos);
    (*live)->change([](LiveSettings& s) { s.mode = LiveMode::Render; s.running = true; });
    live->until([](const LiveState& s) { return s.settings.mode == LiveMode::Render && s.imageSamples == 4 && !s.preview; }, "an image");
    (*live)->useImageAsTarget();
    (*live)->fill(0.5f);
    (*live)->change([](LiveSettings& s) { s.mode = LiveMode::Optimize; s.running = true; });
    const auto state = live->untilStep(3);
    EXPECT_EQ(state->views, 1u);
    EXPECT_EQ(state->picture(LivePicture::Target)->width, kEdge);
    EXPECT_EQ(state->scene->parameters[state->settings.parameters.at(0)].name, "painting.baseColor");
    EXPECT_EQ(state->error.number, 0u) << state->error.what;
}

// Without a parameter there is nothing to recover: the image is seen by the camera that was moved, and so is the target that it becomes.
TEST_F(LiveOptimize, AnImageWithoutAParameterKeepsItsCamera) {
    const auto live = open();
    const auto opened = live->until([](const LiveState& s) { return s.views == 1; }, "the target");
    (*live)->change([](LiveSettings& s) {
        s.mode = LiveMode::Optimize;
        s.camera.toWorld[12] += 0.3f;
        s.parameters = {};
        s.running = true;
    });
    live->until([](const LiveState& s) { return s.settings.parameters.empty() && s.imageSamples == 4 && !s.preview; }, "an image");
    (*live)->pick(12, 12);
    const auto before = live->until([](const LiveState& s) { return s.pick != nullptr; }, "a pick");
    (*live)->useImageAsTarget();
    (*live)->change([&](LiveSettings& s) {
        s.parameters = opened->settings.parameters;
        s.running = false;
    });
    live->until([&](const LiveState& s) { return s.targets != opened->targets && !s.settings.parameters.empty() && !s.refining; }, "the other target");
    (*live)->pick(12, 12);
    const auto after = live->until([](const LiveState& s) { return s.pick->number == 2; }, "another pick");
    ASSERT_TRUE(before->pick->hit);
    EXPECT_EQ(after->pick->position, before->pick->position);
    EXPECT_EQ(after->error.number, 0u) << after->error.what;
}

TEST_F(LiveOptimize, EndsInTheMidstOfAStep) {
    options_.spp = 4096;
    const auto live = open(true);
    live->until([](const LiveState& s) { return s.refining && !s.busy && s.notice.empty(); }, "the step");
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const auto start = std::chrono::steady_clock::now();
    live->close();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    EXPECT_LT(taken.count(), 3); // a submission, or kernels that are being compiled, but no step
}

TEST_F(LiveOptimize, SavesWhatIsSeen) {
    const auto live = open();
    (*live)->stepOnce(2);
    const auto state = live->until([](const LiveState& s) { return s.step == 2 && !s.refining; }, "2 steps");
    (*live)->save(LivePicture::Image, scratch_ / "image.exr");
    (*live)->save(LivePicture::Gradient, scratch_ / "gradient.exr");
    (*live)->save(LivePicture::Gradient, scratch_ / "gradient.png");
    (*live)->save(LivePicture::Parameter, scratch_ / "parameter.png", {.exposure = 1});
    (*live)->saveLoss(scratch_ / "loss.png");
    (*live)->saveLoss(scratch_ / "loss.csv");
    (*live)->saveScene(scratch_ / "saved");
    live->until([](const LiveState& s) { return s.message.number == 7; }, "7 files");
    EXPECT_EQ(readImage(scratch_ / "image.exr").image.values, state->picture(LivePicture::Image)->values);
    EXPECT_EQ(readImage(scratch_ / "gradient.exr").image.values, state->picture(LivePicture::Gradient)->values);
    const std::vector<float> parameter = readImage(scratch_ / "parameter.png").image.values; // a colour of a material, which is not exposed
    for (std::size_t i = 0; i < parameter.size(); ++i)
        ASSERT_EQ(pngCode(parameter[i]), pngCode(state->picture(LivePicture::Parameter)->values[i])) << i;
    EXPECT_GT(readImage(scratch_ / "gradient.png").image.height, readImage(scratch_ / "gradient.png").image.width); // the legend
    std::ifstream rows(scratch_ / "loss.csv");
    std::string header, first, second;
    rows >> header >> first >> second;
    EXPECT_EQ(header, "step,loss");
    EXPECT_EQ(std::stod(first.substr(2)), state->loss->at(0));
    EXPECT_EQ(std::stod(second.substr(2)), state->loss->at(1));
    const Image curve = readImage(scratch_ / "loss.png").image;
    EXPECT_LT(*std::min_element(curve.values.begin(), curve.values.end()), 0.5f); // something is drawn
    const Scene saved = loadScene(scratch_ / "saved/scene.gltf");
    const Image exact = readImage(scratch_ / "saved/parameters/painting.baseColor.exr").image;
    EXPECT_EQ(exact.values, state->picture(LivePicture::Parameter)->values);
    Parameter painting = saved.parameters[saved.parameter("painting.baseColor")];
    painting.materialise();
    EXPECT_NEAR(painting.values[0], exact.values[0], 0.02); // 8 bits
    (*live)->save(LivePicture::Image, scratch_ / "no/such/image.exr"); // makes the folder
    live->until([](const LiveState& s) { return s.message.number == 8; }, "8 files");
    EXPECT_TRUE(std::filesystem::exists(scratch_ / "no/such/image.exr"));
    (*live)->save(LivePicture::Image, scratch_ / "loss.csv/image.exr");
    (*live)->save(LivePicture::Image, scratch_ / "image.txt");
    (*live)->save(LivePicture::Cells, scratch_ / "cells.png");
    (*live)->saveLoss(scratch_ / "loss.txt");
    live->untilError(4);
    EXPECT_EQ((*live)->state()->message.number, 8u);
}

} // namespace
} // namespace cmpg::test

// Recoveries of a linear model by Gauss-Newton: beside Adam, the prior, clipped targets, light, some of many views.
#include "linear_model.h"
#include "base/error.h"
#include "optimize/optimize.h"
#include "optimize/residual.h"

#include <gtest/gtest.h>
#include <iostream>
#include <numeric>
#include <set>
#include <tuple>

namespace cmpg::test {
namespace {

OptimizeConfig newtonConfig(OptimizerKind kind) {
    OptimizeConfig config;
    config.optimizer.kind = kind;
    config.optimizer.rates.fill(0.04f);
    config.sppDifference = 8;
    config.targets = makeTargets(2, 16, 16);
    return config;
}

double errorAfter(OptimizerKind kind, std::uint32_t steps) {
    Scene scene = makeScene();
    LinearModel model(scene, 2, 16, 16, 0.3);
    Optimization run(model, scene, newtonConfig(kind), {0, 1});
    while (run.state().step < steps)
        run.step();
    return rmsError(scene);
}

TEST(GaussNewton, ComesNearerThanAdamInAsManySteps) {
    EXPECT_LT(errorAfter(OptimizerKind::Auto, 20), 0.5 * errorAfter(OptimizerKind::Adam, 20));
    EXPECT_LT(errorAfter(OptimizerKind::Auto, 60), 0.02);
}

Scene makeMaps(const std::vector<SlotKind>& kinds) {
    Scene scene;
    for (const SlotKind kind : kinds)
        scene.parameters.push_back(makeParameter("wall." + std::to_string(scene.parameters.size()), kind, kind == SlotKind::BaseColor ? 4 : 8, 4, 3, 0.5f));
    return scene;
}

std::vector<std::uint32_t> allParameters(const Scene& scene) {
    std::vector<std::uint32_t> all(scene.parameters.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

// Maps of a wall, to which images answer alike, but `factor` times to the second: the loss after so many steps, over that before the first.
double lossOfMaps(const std::vector<SlotKind>& kinds, double factor, std::uint32_t steps) {
    Scene scene = makeMaps(kinds);
    const Scene truth = truthOf(scene, 5, 0.8f);
    LinearModel model(scene, 1, 16, 16, 0), target(truth, 1, 16, 16, 0);
    model.secondFactor = target.secondFactor = factor;
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    config.targets.resize(1);
    config.targets[0].image = target.picture(0, 1, {}, false);
    Optimization run(model, scene, config, allParameters(scene));
    const double before = run.step().loss;
    while (run.state().step < steps - 1)
        run.step();
    return run.step().loss / before;
}

// What one slot brightens, another darkens as much: moved together they would seem to change nothing, and steps be far too long.
TEST(GaussNewton, TellsSlotsApartThatCancelEachOther) { EXPECT_LT(lossOfMaps({SlotKind::BaseColor, SlotKind::Metallic}, -0.95, 40), 1e-4); }

// Each alone would go the whole distance, all together five times as far.
TEST(GaussNewton, TakesSlotsThatDoTheSameNoFartherTogether) {
    EXPECT_LT(lossOfMaps({SlotKind::BaseColor, SlotKind::Metallic, SlotKind::Specular, SlotKind::Clearcoat, SlotKind::Weight}, 1, 20), 1e-3);
}

// How many passes of so many steps are asked where their camera rays met the scene.
int verticesAsked(const std::vector<SlotKind>& kinds, std::size_t views = 2, std::uint32_t steps = 1) {
    Scene scene = makeMaps(kinds);
    LinearModel model(scene, views, 16, 16, 0.3);
    OptimizeConfig config = newtonConfig(OptimizerKind::GaussNewton);
    config.targets = makeTargets(views, 16, 16);
    Optimization run(model, scene, config, allParameters(scene));
    while (run.state().step < steps)
        run.step();
    return model.verticesAsked;
}

// Where maps of several slots answer for each other, where a pixel's answer holds for a short way, or where the texture is near before a step sees all
// views, the diagonal knows better.
TEST(GaussNewton, TexelsAreToldApartOfOneSlotThatImagesAreLinearIn) {
    EXPECT_EQ(verticesAsked({SlotKind::BaseColor}), 2); // by view
    EXPECT_EQ(verticesAsked({SlotKind::BaseColor, SlotKind::BaseColor}), 2);
    EXPECT_EQ(verticesAsked({SlotKind::Metallic}), 2);
    EXPECT_EQ(verticesAsked({SlotKind::Roughness}), 0);
    EXPECT_EQ(verticesAsked({SlotKind::Emission}), 0);
    EXPECT_EQ(verticesAsked({SlotKind::BaseColor, SlotKind::Metallic}), 0);
    EXPECT_EQ(verticesAsked({SlotKind::BaseColor}, 3, 60), 9); // in three steps
    EXPECT_EQ(verticesAsked({SlotKind::BaseColor}, 6, 60), 0);
}

// Of targets that are clipped at the mean of their values, and say so or not.
double errorOfClipped(bool told, std::uint32_t steps) {
    Scene scene = makeScene();
    LinearModel model(scene, 2, 16, 16, 0.05);
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    for (Target& target : config.targets) {
        std::vector<float>& values = target.image.values;
        const float limit = std::accumulate(values.begin(), values.end(), 0.f) / float(values.size());
        for (float& value : values) {
            if (told)
                target.clipped.push_back(value >= limit);
            value = std::min(value, limit);
        }
    }
    Optimization run(model, scene, config, {0, 1});
    while (run.state().step < steps)
        run.step();
    return rmsError(scene);
}

TEST(GaussNewton, LooksBeyondWhatIsClipped) {
    EXPECT_LT(errorOfClipped(true, 60), 0.02);
    EXPECT_GT(errorOfClipped(false, 60), 0.1);
}

// Per pixel, of the images that steps bring up to date, in a recovery of one view.
std::vector<double> imageSamples(double noise, std::uint32_t steps) {
    Scene scene = makeScene();
    LinearModel model(scene, 1, 16, 16, noise);
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    config.targets = makeTargets(1, 16, 16);
    Optimization run(model, scene, config, {0, 1});
    while (run.state().step < steps)
        run.step();
    std::vector<double> samples;
    for (const LinearModel::Call& call : model.calls)
        if (call.kind == 'p' && call.key.firstSample > 0) // the first image has none before it
            samples.push_back(double(call.samples) / (16 * 16));
    return samples;
}

TEST(GaussNewton, ImagesGetSamplesWhenNoiseIsWhatIsLeft) {
    const std::vector<double> noisy = imageSamples(0.3, 40), clean = imageSamples(0, 40);
    ASSERT_EQ(noisy.size(), 39u);
    ASSERT_EQ(clean.size(), 39u);
    EXPECT_GT(noisy.back(), 7); // of 8
    for (const double samples : clean)
        EXPECT_NEAR(samples, 5, 0.3); // between 2 and 8 while gradients are signal
}

double errorAfter(std::vector<Target> targets, double prior, double noise, std::uint32_t steps) {
    Scene scene = makeScene();
    LinearModel model(scene, 2, 16, 16, noise);
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    config.targets = std::move(targets);
    config.prior = prior;
    Optimization run(model, scene, config, {0, 1});
    while (run.state().step < steps)
        run.step();
    return rmsError(scene);
}

// Images are trusted by their noise: the prior pulls noticeably at values while little is known, and no longer when images have told them.
TEST(GaussNewton, PriorFadesAsImagesGetPrecise) {
    const std::vector<Target> targets = makeTargets(2, 16, 16);
    EXPECT_LT(errorAfter(targets, 8, 0, 100), 1e-3);
    const double early = errorAfter(targets, 8, 0.3, 10), late = errorAfter(targets, 8, 0.3, 160);
    EXPECT_LT(late, 0.3 * early);
}

// The prior's weight follows from how far images are off: by the noise of a target as well, which no samples take away.
TEST(GaussNewton, PriorStaysWhereTargetsAreNoisy) {
    const auto weight = [](double off) {
        Scene scene = makeScene();
        LinearModel model(scene, 2, 16, 16, 0);
        OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
        config.prior = 8;
        std::mt19937 random(8);
        std::normal_distribution<float> normal(0, 1);
        for (Target& target : config.targets)
            for (float& value : target.image.values)
                value += float(off) * normal(random);
        Optimization run(model, scene, config, {0, 1});
        while (run.state().step < 60)
            run.step();
        std::vector<double> ignored(scene.parameters[0].entries());
        const double variation = addTotalVariation(scene.parameters[0], 1, ignored, kPriorCost);
        return run.step().regularizer / variation;
    };
    constexpr double kOff = 0.02, kEntries = 48, kValues = 2 * 16 * 16 * 3;
    EXPECT_NEAR(weight(kOff) / (8 * kEntries * 2 * kOff * kOff / kValues), 1, 0.2);
    EXPECT_LT(weight(0), 0.1 * weight(kOff));
}

// Images that are noisier than what is tolerated are trusted as if they were off by that.
TEST(GaussNewton, PriorGrowsNoFartherThanWhatIsTolerated) {
    constexpr double kNoise = 20, kEntries = 48, kValues = 16 * 16 * 3; // of a sample, times its value; of a view
    const std::vector<Target> targets = makeTargets(2, 16, 16);
    double information = 0;
    for (const Target& target : targets)
        information += kValues / toleratedLoss(Loss::Mse, target);
    const auto weight = [&](OptimizerKind kind) { // over that of an image that is off by what is tolerated
        Scene scene = makeScene();
        LinearModel model(scene, 2, 16, 16, kNoise);
        OptimizeConfig config = newtonConfig(kind);
        config.targets = targets;
        config.prior = 8;
        Optimization run(model, scene, config, {0, 1});
        while (run.state().step < 3)
            run.step();
        std::vector<double> ignored(scene.parameters[0].entries());
        const double variation = addTotalVariation(scene.parameters[0], 1, ignored, kPriorCost);
        return run.step().regularizer / variation / (8 * kEntries / information);
    };
    for (const OptimizerKind kind : {OptimizerKind::Auto, OptimizerKind::Adam})
        EXPECT_NEAR(weight(kind), 1, 0.01);
}

// A texture of light, recovered from one noisy view that shows it `brightness` times as bright, from a hundredth of that.
std::vector<float> recoveredLight(float brightness, double prior, double noise, std::uint32_t steps) {
    const auto scene = [&](bool truth) {
        Scene made;
        made.parameters.push_back(makeParameter("lamp.emission", SlotKind::Emission, 4, 4, 3, 0.01f * brightness));
        const std::vector<float> values = makeTruth().parameters[0].values;
        for (std::size_t i = 0; truth && i < values.size(); ++i)
            made.parameters[0].values[i] = values[i] * brightness;
        return made;
    };
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    config.prior = prior;
    config.targets.resize(1);
    config.targets[0].image = LinearModel(scene(true), 1, 16, 16, 0).picture(0, 1, {}, false);
    Scene made = scene(false);
    LinearModel model(made, 1, 16, 16, noise);
    Optimization run(model, made, config, {0});
    while (run.state().step < steps)
        run.step();
    return made.parameters[0].values;
}

TEST(GaussNewton, ReachesLightFromFarTooDark) {
    const std::vector<float> truth = makeTruth().parameters[0].values, found = recoveredLight(1, 0, 0, 40);
    for (std::size_t i = 0; i < truth.size(); ++i)
        EXPECT_NEAR(found[i], truth[i], 0.02);
}

// The prior of light has no unit of its own: twice as bright is recovered as twice the values. And it smoothes while images are noisy.
TEST(GaussNewton, PriorOfLightIsTheSameAtAnyBrightness) {
    const std::vector<float> one = recoveredLight(1, 400, 0.3, 20), bright = recoveredLight(1024, 400, 0.3, 20), without = recoveredLight(1, 0, 0.3, 20);
    for (std::size_t i = 0; i < one.size(); ++i)
        EXPECT_NEAR(bright[i] / 1024, one[i], 1e-4);
    const auto variation = [](const std::vector<float>& values) {
        Parameter texture = makeParameter("lamp.emission", SlotKind::Emission, 4, 4, 3, 0);
        texture.values = values;
        std::vector<double> ignored(texture.entries());
        return addTotalVariation(texture, 1, ignored);
    };
    EXPECT_LT(variation(one), 0.9 * variation(without));
}

// Pixels that answer to the parameters get the samples, every pixel one at least, and all together about as many as asked for.
TEST(GaussNewton, ImagesAreSampledWhereTheyAnswer) {
    Scene scene = makeScene();
    LinearModel model(scene, 2, 16, 16, 0.3);
    Optimization run(model, scene, newtonConfig(OptimizerKind::Auto), {0, 1});
    run.step();
    model.calls.clear();
    run.step();
    ASSERT_EQ(run.state().pixelShares.size(), 2u);
    std::uint64_t paths = 0;
    for (const LinearModel::Call& call : model.calls)
        paths += call.kind == 'p' && call.key.step < 2 ? call.samples : 0; // beside those that measure the curvature
    EXPECT_GT(double(paths), 2.0 * 5 * 256 * 0.9); // half of the samples, and more by the share of noise
    EXPECT_LT(double(paths), 2.0 * 8 * 256 * 1.1);
}

// Error after as many passes of a view as `steps` of all six take, of a texture alone.
double errorOfViews(std::uint32_t viewsPerStep, std::uint32_t steps, double noise, std::size_t imageBytes = std::size_t(1) << 20) {
    Scene scene = makeScene(), truth = makeTruth();
    scene.parameters.pop_back();
    truth.parameters.pop_back();
    LinearModel model(scene, 6, 16, 16, noise), exact(truth, 6, 16, 16, 0);
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    config.targets.resize(6);
    for (std::size_t view = 0; view < 6; ++view)
        config.targets[view].image = exact.picture(view, 1, {}, false);
    config.viewsPerStep = viewsPerStep;
    config.imageBytes = imageBytes;
    Optimization run(model, scene, config, {0});
    const ViewOrder order(config.seed, 6, viewsPerStep);
    while (order.seenBefore(run.state().step) < 6 * steps)
        run.step();
    double squares = 0;
    for (std::size_t i = 0; i < 48; ++i)
        squares += std::pow(double(scene.parameters[0].values[i]) - truth.parameters[0].values[i], 2) / 48;
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> keys;
    for (const LinearModel::Call& call : model.calls) {
        EXPECT_TRUE(keys.emplace(call.key.step, call.key.pass, call.key.firstSample).second) << "random numbers used twice";
    }
    std::cout << viewsPerStep << " views a step, error " << std::sqrt(squares) << '\n';
    return std::sqrt(squares);
}

TEST(GaussNewton, ComesNearerWithFewViewsAtFirst) {
    for (const double noise : {0.0, 0.3}) {
        const double all = errorOfViews(6, 3, noise);
        EXPECT_LT(errorOfViews(1, 3, noise), 0.7 * all) << noise;
        EXPECT_LT(errorOfViews(0, 3, noise), 0.7 * all) << noise;
    }
    EXPECT_LT(errorOfViews(0, 20, 0.3), 1.2 * errorOfViews(6, 20, 0.3)); // and no farther at last
}

// A texture goes on where steps saw all views, or begins in the middle of an order of views: either way what bounds its steps is measured anew, of all of them.
TEST(GaussNewton, MeasuresTheCurvatureOfViewsThatTakeTurnsAnew) {
    constexpr std::size_t kViews = 6;
    Scene scene = makeScene(), truth = makeTruth();
    scene.parameters.pop_back();
    truth.parameters.pop_back();
    LinearModel model(scene, kViews, 16, 16, 0), exact(truth, kViews, 16, 16, 0);
    OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
    config.targets.resize(kViews);
    for (std::size_t view = 0; view < kViews; ++view)
        config.targets[view].image = exact.picture(view, 1, {}, false);
    config.viewsPerStep = kViews;
    Optimization all(model, scene, config, {0});
    all.step();
    all.step();
    const auto sumOf = [](const std::vector<float>& values) { return std::accumulate(values.begin(), values.end(), 0.0); };
    const double exactSum = sumOf(all.state().moments[0].second);
    OptimizeConfig turns = config;
    turns.viewsPerStep = 1;
    for (const bool fresh : {false, true}) {
        OptimizeState start;
        start.step = 2; // of six, of the first order
        if (!fresh)
            start.moments = all.state().moments;
        else {
            start.moments = {initialMoments(turns.optimizer, scene.parameters[0])};
            start.moments[0].start = start.step;
        }
        Scene own = scene;
        Optimization some(model, own, turns, {0}, start);
        EXPECT_EQ(some.state().moments[0].start, 2u);
        for (int step = 0; step < 4 + 6; ++step) // the rest of the first order, and all of the next
            some.step();
        const Moments& now = some.state().moments[0];
        ASSERT_EQ(now.peak.size(), 48u);
        // Images are linear in the texture: the mean over the views is that of all, and four of six were measured twice.
        EXPECT_NEAR(sumOf(now.second), 10 / 6.0 * exactSum, 0.1 * exactSum) << fresh;
        EXPECT_GE(sumOf(now.peak), exactSum) << fresh;
    }
    Optimization back(model, scene, config, {0}, {.step = 3, .moments = [&] {
        Scene own = scene;
        Optimization some(model, own, turns, {0});
        for (int step = 0; step < 3; ++step) // half of the views
            some.step();
        return some.state().moments;
    }()});
    back.step();
    EXPECT_TRUE(back.state().moments[0].peak.empty());
    EXPECT_NEAR(sumOf(back.state().moments[0].second), exactSum, 0.05 * exactSum);
}

TEST(GaussNewton, CarriesImagesOfAsManyViewsAsMemoryAllows) {
    for (const std::uint32_t viewsPerStep : {1u, 6u}) {
        Scene scene = makeScene(), truth = makeTruth();
        LinearModel model(scene, 6, 16, 16, 0.3), exact(truth, 6, 16, 16, 0);
        OptimizeConfig config = newtonConfig(OptimizerKind::Auto);
        config.targets.resize(6);
        for (std::size_t view = 0; view < 6; ++view)
            config.targets[view].image = exact.picture(view, 1, {}, false);
        config.viewsPerStep = viewsPerStep;
        const std::size_t image = RunningImage::bytes(256), values = 4 * (scene.parameters[0].entries() + scene.parameters[1].entries());
        config.imageBytes = 3 * image + (viewsPerStep == 1 ? 3 : 1) * values; // values of a step that sees all views are of all images
        Optimization run(model, scene, config, {0, 1});
        for (int step = 0; step < 12; ++step)
            run.step();
        std::set<const StepValues*> sets;
        for (std::size_t view = 0; view < 6; ++view) {
            EXPECT_EQ(run.state().images[view].empty(), view >= 3) << view;
            EXPECT_EQ(run.state().imageValues[view] == nullptr, view >= 3) << view;
            sets.insert(run.state().imageValues[view].get());
        }
        EXPECT_EQ(sets.size(), viewsPerStep == 1 ? 4u : 2u); // with none
    }
}

// Images beyond the memory for them begin anew, with random numbers of their own: their noise is larger, and still not what the values fit.
TEST(GaussNewton, RecoversWhereImagesBeginAnew) { EXPECT_LT(errorOfViews(1, 20, 0.3, 0), 4 * errorOfViews(1, 20, 0.3)); }

TEST(GaussNewton, SaysWhatItNeeds) {
    const auto refused = [](auto&& change) {
        OptimizeConfig config = newtonConfig(OptimizerKind::GaussNewton);
        change(config);
        Scene scene = makeScene();
        LinearModel model(scene, 2, 16, 16, 0.3);
        try {
            Optimization run(model, scene, config, {0, 1});
            return false;
        } catch (const Error& error) {
            return error.kind == ErrorKind::Usage && !error.remedy.empty();
        }
    };
    EXPECT_FALSE(refused([](OptimizeConfig&) {}));
    EXPECT_TRUE(refused([](OptimizeConfig& c) { c.loss = Loss::L1; }));
    EXPECT_TRUE(refused([](OptimizeConfig& c) { c.sppDifference = 0; }));
    EXPECT_FALSE(refused([](OptimizeConfig& c) { c.viewsPerStep = 1; }));
    EXPECT_EQ(methodOf(OptimizerKind::Auto, SlotKind::BaseColor, true), OptimizerKind::GaussNewton);
    EXPECT_EQ(methodOf(OptimizerKind::Auto, SlotKind::BaseColor, false), OptimizerKind::Adam);
    EXPECT_EQ(methodOf(OptimizerKind::Auto, SlotKind::Roughness, true), OptimizerKind::GaussNewton);
    EXPECT_EQ(methodOf(OptimizerKind::Auto, SlotKind::Normal, true), OptimizerKind::GaussNewton);
    EXPECT_EQ(methodOf(OptimizerKind::Auto, SlotKind::SheenColor, true), OptimizerKind::Adam);
    EXPECT_EQ(methodOf(OptimizerKind::Sgd, SlotKind::BaseColor, true), OptimizerKind::Sgd);
}

} // namespace
} // namespace cmpg::test

// The step on a linear model with known solution: convergence, random numbers, views, stopping, failures.
#include "base/error.h"
#include "linear_model.h"
#include "optimize/optimize.h"
#include "optimize/regularizer.h"
#include "optimize/view_order.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <tuple>

namespace cmpg {
namespace {

using test::LinearModel;

OptimizeConfig makeConfig(std::size_t views, int width = 8, int height = 8) {
    OptimizeConfig config;
    config.steps = 300;
    config.optimizer.schedule = Schedule::Cosine;
    config.optimizer.finalFactor = 0.01f;
    config.targets = test::makeTargets(views, width, height);
    return config;
}

// Runs to the end and returns the scene.
Scene optimise(OptimizeConfig config, double noise, std::vector<StepReport>* reports = nullptr, PixelSampling pixels = PixelSampling::Adjoint) {
    Scene scene = test::makeScene();
    LinearModel model(scene, config.targets.size(), config.targets[0].image.width, config.targets[0].image.height, noise);
    model.pixels = pixels;
    Optimization run(model, scene, std::move(config), {0, 1});
    test::runSteps(run, [&](const StepReport& report) {
        if (reports)
            reports->push_back(report);
    });
    return scene;
}

TEST(Optimize, RecoversTheParametersOfALinearModel) {
    const double start = test::rmsError(test::makeScene());
    for (const Loss loss : {Loss::Mse, Loss::L1, Loss::Smape, Loss::RelativeMse}) {
        OptimizeConfig config = makeConfig(1);
        config.loss = loss;
        config.steps = 1000; // relative-mse is badly conditioned: pixels whose target is near 0 weigh a hundred times more
        std::vector<StepReport> reports;
        const Scene scene = optimise(config, 0, &reports);
        // The last steps are 1 % of a rate of 0.02: what is left oscillates within a few of them.
        EXPECT_LT(test::rmsError(scene), 2e-3) << nameOf(loss, kLosses) << " from " << start;
        EXPECT_EQ(reports.size(), 1000u);
        EXPECT_LT(reports.back().loss, 0.02 * reports.front().loss);
    }
}

// Below its floor a roughness has no derivative, so no step may end there; what begins there is brought to where it has one.
TEST(Optimize, NoStepEndsBelowAFloor) {
    for (const OptimizerKind kind : {OptimizerKind::Adam, OptimizerKind::Sgd, OptimizerKind::GaussNewton})
        for (const std::uint32_t width : {1u, 2u}) { // a constant and a texture
            Scene scene;
            scene.parameters.push_back(test::makeParameter("ball.roughness", SlotKind::Roughness, width, 1, 1, 0.05f));
            scene.parameters[0].values.back() = 0;
            scene.materials.emplace_back().parameters[std::size_t(SlotKind::Roughness)] = 0;
            OptimizeConfig config = makeConfig(1);
            config.optimizer.kind = kind;
            config.targets[0].image.values.assign(config.targets[0].image.values.size(), 0.f); // of roughness 0
            LinearModel model(scene, 1, 8, 8, 0);
            Optimization run(model, scene, std::move(config), {0});
            for (int step = 0; step < 20; ++step) {
                run.step();
                for (const float value : scene.parameters[0].values)
                    EXPECT_GT(value, scene.floorOf(0)) << int(kind) << ", " << step;
            }
        }
}

TEST(ViewOrder, SeesEachViewOnceARoundInRandomOrder) {
    EXPECT_EQ(ViewOrder(1, 3, 3).viewsOf(7), (std::vector<std::size_t>{0, 1, 2}));
    EXPECT_EQ(ViewOrder(1, 3, 5).viewsOf(7), (std::vector<std::size_t>{0, 1, 2}));
    for (const std::uint32_t perStep : {1u, 2u, 3u, 4u}) {
        const ViewOrder order(5, 5, perStep);
        const std::uint32_t steps = (5 + perStep - 1) / perStep; // of a round
        for (std::uint32_t round = 0; round < 6; ++round) {
            std::multiset<std::size_t> seen;
            for (std::uint32_t step = round * steps; step < (round + 1) * steps; ++step) {
                const std::vector<std::size_t> now = order.viewsOf(step);
                EXPECT_EQ(order.seenBefore(step), 5 * round + seen.size());
                EXPECT_GE(now.size(), 5 / steps);
                EXPECT_LE(now.size(), perStep);
                seen.insert(now.begin(), now.end());
            }
            EXPECT_EQ(seen, (std::multiset<std::size_t>{0, 1, 2, 3, 4}));
        }
    }
    // All 6 orders of three views are equally likely: 3000 rounds, chi-squared with 5 degrees of freedom, 99.99 % below 25.7; fixed seed.
    const ViewOrder three(9, 3, 1);
    std::map<std::vector<std::size_t>, int> orders;
    for (std::uint32_t round = 0; round < 3000; ++round)
        ++orders[{three.viewsOf(3 * round)[0], three.viewsOf(3 * round + 1)[0], three.viewsOf(3 * round + 2)[0]}];
    ASSERT_EQ(orders.size(), 6u);
    double chiSquared = 0;
    for (const auto& [order, count] : orders)
        chiSquared += (count - 500) * (count - 500) / 500.0;
    EXPECT_LT(chiSquared, 25.7);
    EXPECT_NE(ViewOrder(1, 1000, 10).viewsOf(0), ViewOrder(2, 1000, 10).viewsOf(0));
}

TEST(ViewOrder, CountsOrdersThatBeganAtAStepOrLater) {
    const ViewOrder order(2, 6, 4); // two steps each
    EXPECT_EQ(order.wholeOrders(0, 1), 0u);
    EXPECT_EQ(order.wholeOrders(0, 2), 1u);
    EXPECT_EQ(order.wholeOrders(0, 7), 3u);
    EXPECT_EQ(order.wholeOrders(1, 2), 0u); // the rest of the first
    EXPECT_EQ(order.wholeOrders(1, 3), 0u);
    EXPECT_EQ(order.wholeOrders(1, 4), 1u);
    EXPECT_EQ(order.wholeOrders(5, 5), 0u);
}

TEST(ViewOrder, GrowsFromOneView) {
    for (const std::size_t views : {1u, 2u, 5u, 12u, 200u}) {
        const ViewOrder order(3, views, 0);
        const std::size_t most = std::min<std::size_t>(views, 16);
        std::uint64_t seen = 0;
        std::uint32_t step = 0;
        for (std::size_t round = 0; round < 20; ++round) {
            std::set<std::size_t> ofRound;
            const std::size_t count = std::min(round + 1, most), steps = (views + count - 1) / count;
            for (std::size_t i = 0; i < steps; ++i, ++step) {
                EXPECT_EQ(order.seenBefore(step), seen);
                const std::vector<std::size_t> now = order.viewsOf(step);
                EXPECT_GE(now.size(), views / steps);
                EXPECT_LE(now.size(), count);
                EXPECT_EQ(order.seesAll(step), now.size() == views);
                EXPECT_EQ(step >= order.stepsBeforeAll(), now.size() == views);
                ofRound.insert(now.begin(), now.end());
                seen += now.size();
            }
            EXPECT_EQ(ofRound.size(), views); // each once
            EXPECT_EQ(seen, (round + 1) * views);
        }
    }
    EXPECT_EQ(ViewOrder(3, 5, 2).stepsBeforeAll(), ~0u);
    EXPECT_EQ(ViewOrder(3, 5, 5).stepsBeforeAll(), 0u);
}

// Steps see 17 views in unequal numbers: no derivative pass has the numbers of another.
TEST(Optimize, ViewsNeverShareNumbers) {
    constexpr std::size_t kViews = 17;
    OptimizeConfig config = makeConfig(kViews);
    config.optimizer.kind = OptimizerKind::GaussNewton;
    config.steps = 60;
    Scene scene = test::makeScene();
    scene.parameters.resize(1); // with a constant all steps see all views
    LinearModel model(scene, kViews, 8, 8, 0.1);
    Optimization run(model, scene, config, {0});
    test::runSteps(run, [](const StepReport&) {});
    std::set<std::uint32_t> used;
    for (const LinearModel::Call& call : model.calls)
        if (call.kind == 'g' && call.key.pass == 1) {
            EXPECT_TRUE(used.insert(call.key.step).second) << call.key.step;
        }
    EXPECT_GT(used.size(), 200u);
}

// Adam's first step has the length of the rate however long the model learned before, and so has the next one along the same gradient.
TEST(Optimize, StepsAfterAWarmUpHaveTheirRate) {
    for (const std::uint32_t warmUp : {0u, 20u}) {
        OptimizeConfig config = makeConfig(1);
        config.optimizer.kind = OptimizerKind::Adam;
        config.warmUp = warmUp;
        config.steps = warmUp + 2;
        Scene scene = test::makeScene();
        for (float& value : scene.parameters[0].values)
            value = 0.5f;
        LinearModel model(scene, 1, 8, 8, 0);
        Optimization run(model, scene, config, {0, 1});
        std::vector<float> before = scene.parameters[0].values;
        while (run.state().step < config.steps) {
            const StepReport report = run.step();
            float largest = 0;
            for (std::size_t i = 0; i < before.size(); ++i)
                largest = std::max(largest, std::abs(scene.parameters[0].values[i] - before[i]));
            if (report.step >= warmUp) {
                EXPECT_NEAR(largest, report.rate, 0.05 * report.rate) << warmUp << " step " << report.step;
            }
            before = scene.parameters[0].values;
        }
    }
}

TEST(Optimize, SomeViewsAStepHaveTheGradientOfAllOnAverage) {
    const std::size_t views = 6;
    const auto meanGradient = [&](std::uint32_t perStep, std::set<std::pair<std::uint32_t, std::uint32_t>>& keys) {
        OptimizeConfig config = makeConfig(views);
        config.viewsPerStep = perStep;
        config.sppDifference = 0;
        config.steps = config.warmUp = views; // the parameters stay where they are
        Scene scene = test::makeScene();
        LinearModel model(scene, views, 8, 8, 0);
        model.pixels = PixelSampling::Uniform;
        Optimization run(model, scene, config, {0, 1});
        std::vector<std::vector<double>> mean = {std::vector<double>(48), std::vector<double>(3)};
        double loss = 0;
        test::runSteps(run, [&](const StepReport& report) {
            loss = report.loss; // of each view where it was seen last
            for (std::size_t k = 0; k < mean.size(); ++k)
                for (std::size_t i = 0; i < mean[k].size(); ++i)
                    mean[k][i] += run.gradients()[k][i] / double(views);
        });
        for (const LinearModel::Call& call : model.calls)
            if (call.kind == 'p') {
                EXPECT_TRUE(keys.insert({call.key.step, call.key.firstSample}).second) << "random numbers used twice";
            }
        mean.push_back({loss});
        return mean;
    };
    std::set<std::pair<std::uint32_t, std::uint32_t>> keys;
    const auto all = meanGradient(0, keys);
    for (const std::uint32_t perStep : {1u, 2u, 4u}) { // six steps: whole rounds
        std::set<std::pair<std::uint32_t, std::uint32_t>> own;
        const auto some = meanGradient(perStep, own);
        EXPECT_EQ(own.size(), views * (perStep == 4 ? 3 : perStep)); // two steps of three are the fewest of four at most
        for (std::size_t k = 0; k < all.size(); ++k)
            for (std::size_t i = 0; i < all[k].size(); ++i)
                EXPECT_NEAR(some[k][i], all[k][i], 1e-6 * std::abs(all[k][i]) + 1e-9);
    }
}

TEST(Optimize, RecoversFromSomeViewsAStep) {
    OptimizeConfig config = makeConfig(4);
    config.viewsPerStep = 1;
    config.steps = 1000;
    EXPECT_LT(test::rmsError(optimise(config, 0)), 5e-3);
}

TEST(Optimize, SgdRecoversThemToo) {
    OptimizeConfig config = makeConfig(1);
    config.optimizer.kind = OptimizerKind::Sgd;
    EXPECT_LT(test::rmsError(optimise(config, 0)), 2e-3);
}

TEST(Optimize, ConvergesFromNoisyImagesWithBothPixelSamplings) {
    const double start = test::rmsError(test::makeScene());
    for (const PixelSampling sampling : {PixelSampling::Uniform, PixelSampling::Adjoint}) {
        OptimizeConfig config = makeConfig(1, 16, 16);
        EXPECT_LT(test::rmsError(optimise(config, 0.5, nullptr, sampling)), start / 10);
    }
}

TEST(Optimize, FirstGradientIsTheDerivativeOfTheMeanLossOverTheViews) {
    const std::size_t views = 3;
    OptimizeConfig config = makeConfig(views);
    config.totalVariation = 0.05;
    // Loss and regulariser of the scene with one entry moved by h, from a run's first step.
    const auto first = [&](std::size_t parameter, std::size_t entry, float h, std::vector<std::vector<double>>* gradients) {
        Scene scene = test::makeScene();
        scene.parameters[0].values = test::makeTruth().parameters[1].values; // not flat, so that the regulariser is at work
        scene.parameters[0].values.resize(48, 0.4f);
        scene.parameters[parameter].values[entry] += h;
        LinearModel model(scene, views, 8, 8, 0);
        model.pixels = PixelSampling::Uniform;
        Optimization run(model, scene, config, {0, 1});
        const StepReport report = run.step();
        if (gradients)
            *gradients = run.gradients();
        return report.loss + report.regularizer;
    };
    std::vector<std::vector<double>> gradients;
    first(0, 0, 0, &gradients);
    for (const auto& [parameter, entry] : {std::pair<std::size_t, std::size_t>{0, 0}, {0, 13}, {0, 47}, {1, 0}, {1, 2}}) {
        const float h = 0x1p-10f;
        const double numeric = (first(parameter, entry, h, nullptr) - first(parameter, entry, -h, nullptr)) / (2 * h);
        // The loss is quadratic; the image is rounded to float (1e-7 / h = 1e-4 at worst, averaged over the pixels that change); the
        // regulariser's curvature where differences are of the order of eps adds up to 5e-5.
        EXPECT_NEAR(gradients[parameter][entry], numeric, 1e-4) << parameter << "." << entry;
    }
}

TEST(Optimize, NoTwoPassesShareTheirRandomNumbers) {
    OptimizeConfig config = makeConfig(2);
    config.steps = 5;
    Scene scene = test::makeScene();
    LinearModel model(scene, 2, 8, 8, 0.1);
    Optimization run(model, scene, config, {0, 1});
    test::runSteps(run);
    run.render(0, 4);
    run.render(1, 4);
    std::set<std::tuple<std::uint64_t, std::uint32_t, std::uint32_t, std::uint32_t>> keys; // the images of a view are one sequence of samples
    for (const LinearModel::Call& call : model.calls) {
        EXPECT_EQ(call.key.seed, config.seed);
        EXPECT_EQ(call.key.pass, call.kind == 'p' ? 0u : 1u);
        keys.insert({call.key.seed, call.key.step, call.key.pass, call.key.firstSample});
    }
    EXPECT_EQ(model.calls.size(), 5u * 2 * 2 + 2);
    EXPECT_EQ(keys.size(), model.calls.size());
    // Images for the report share theirs at any time.
    run.render(0, 4);
    EXPECT_EQ(model.calls.back().key.step, model.calls[model.calls.size() - 3].key.step);
}

TEST(Optimize, CountsItsSamples) {
    for (const PixelSampling sampling : {PixelSampling::Uniform, PixelSampling::Adjoint}) {
        OptimizeConfig config = makeConfig(2);
        config.steps = 3;
        Scene scene = test::makeScene();
        LinearModel model(scene, 2, 8, 8, 0);
        model.pixels = sampling;
        Optimization run(model, scene, config, {0, 1});
        std::uint64_t reported = 0, taken = 0;
        test::runSteps(run, [&](const StepReport& report) { reported += report.samples; });
        for (const LinearModel::Call& call : model.calls)
            taken += call.samples;
        EXPECT_EQ(reported, taken);
    }
}

TEST(Optimize, EqualRunsAreEqualBitByBit) {
    const Scene a = optimise(makeConfig(2), 0.3), b = optimise(makeConfig(2), 0.3);
    EXPECT_EQ(a.parameters[0].values, b.parameters[0].values);
    EXPECT_EQ(a.parameters[1].values, b.parameters[1].values);
    OptimizeConfig other = makeConfig(2);
    other.seed = 1;
    EXPECT_NE(a.parameters[0].values, optimise(other, 0.3).parameters[0].values);
}

TEST(Optimize, ReportsAGradientNormPerParameter) {
    OptimizeConfig config = makeConfig(1);
    config.steps = 10;
    Scene scene = test::makeScene();
    LinearModel model(scene, 1, 8, 8, 0);
    model.breakGradients = [](std::vector<std::vector<double>>& gradients) { EXPECT_EQ(gradients.size(), 2u); };
    Optimization run(model, scene, config, {0, 1});
    test::runSteps(run);
    EXPECT_NE(scene.parameters[0].values, test::makeScene().parameters[0].values);
    for (const double norm : run.step().gradientNorm)
        EXPECT_GT(norm, 0);
}

TEST(Optimize, NonFiniteGradientsAreSkippedAndCounted) {
    OptimizeConfig config = makeConfig(1);
    Scene scene = test::makeScene();
    LinearModel model(scene, 1, 8, 8, 0);
    model.breakGradients = [](std::vector<std::vector<double>>& gradients) { gradients[0][5] = gradients[0][6] = std::nan(""); };
    model.breakImage = [](Image& image) { image.values[0] = std::nanf(""); };
    Optimization run(model, scene, config, {0, 1});
    for (int i = 0; i < 5; ++i) {
        const StepReport report = run.step();
        EXPECT_EQ(report.dropped, 3u);
        EXPECT_TRUE(std::isfinite(report.loss));
        EXPECT_TRUE(std::isfinite(report.gradientNorm[0]));
    }
    EXPECT_EQ(scene.parameters[0].values[5], 0.5f);
    EXPECT_NE(scene.parameters[0].values[7], 0.5f);
}

TEST(Optimize, FailsWhenNoGradientIsFinite) {
    OptimizeConfig config = makeConfig(1);
    Scene scene = test::makeScene();
    LinearModel model(scene, 1, 8, 8, 0);
    model.breakGradients = [](std::vector<std::vector<double>>& gradients) {
        for (std::vector<double>& gradient : gradients)
            std::fill(gradient.begin(), gradient.end(), INFINITY);
    };
    Optimization run(model, scene, config, {0, 1});
    try {
        run.step();
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind, ErrorKind::Numerical);
        EXPECT_FALSE(error.remedy.empty());
    }
    EXPECT_EQ(scene.parameters[0].values, test::makeScene().parameters[0].values);
}

TEST(Optimize, RefusesTargetsOfAnotherSizeOrNumber) {
    Scene scene = test::makeScene();
    LinearModel model(scene, 1, 9, 8, 0);
    try {
        Optimization run(model, scene, makeConfig(1), {0, 1});
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind, ErrorKind::Input);
        EXPECT_NE(std::string(error.what()).find("8 x 8"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("9 x 8"), std::string::npos);
    }
    LinearModel two(scene, 2, 8, 8, 0);
    EXPECT_THROW(Optimization(two, scene, makeConfig(1), {0, 1}), Error);
}

TEST(Optimize, TotalVariationSmooths) {
    OptimizeConfig config = makeConfig(1);
    const auto variation = [](const Scene& scene) {
        double sum = 0;
        const std::vector<float>& values = scene.parameters[0].values;
        for (std::size_t i = 3; i < values.size(); ++i)
            sum += std::abs(values[i] - values[i - 3]);
        return sum;
    };
    const double rough = variation(optimise(config, 0));
    config.totalVariation = 1;
    EXPECT_LT(variation(optimise(config, 0)), 0.3 * rough);
}

// -log of the posterior over -log of the likelihood's scale: loss + prior / information * sum |d|, where the images' information is their number
// of values over the loss of one that is off by 10 % of the target's mean, as long as images are off by more.
TEST(Optimize, ThePriorWeighsDifferencesAgainstImagesTrustedToTenPercent) {
    constexpr float kFarOff = 2;
    const auto firstStep = [](double prior) {
        OptimizeConfig config = makeConfig(1);
        config.totalVariation = 0;
        config.prior = prior;
        for (float& value : config.targets[0].image.values)
            value *= kFarOff;
        Scene scene = test::makeTruth(); // differs from texel to texel
        LinearModel model(scene, 1, 8, 8, 0);
        Optimization run(model, scene, config, {0, 1});
        const double regularizer = run.step().regularizer;
        return std::pair(regularizer, run.gradients());
    };
    const auto [none, plain] = firstStep(0);
    const auto [weight, pulled] = firstStep(5);
    EXPECT_EQ(none, 0);

    const std::vector<Target> targets = test::makeTargets(1, 8, 8);
    double sum = 0;
    for (const float v : targets[0].image.values)
        sum += std::abs(double(kFarOff * v));
    const double values = double(targets[0].image.values.size()), off = 0.1 * sum / values, tolerated = off * off;
    const Parameter texture = test::makeTruth().parameters[0];
    std::vector<double> gradient(texture.entries());
    const double unit = addTotalVariation(texture, 5 * tolerated / values * double(texture.entries()), gradient, kPriorCost);
    EXPECT_NEAR(weight, unit, 1e-4 * unit);
    for (std::size_t i = 0; i < gradient.size(); ++i)
        EXPECT_NEAR(pulled[0][i] - plain[0][i], gradient[i], 1e-4 * unit) << i;
    EXPECT_EQ(pulled[1], plain[1]); // light has none
}

TEST(Optimize, RecordsTheSecondsOfTheWholeStep) {
    Scene scene = test::makeTruth();
    LinearModel model(scene, 1, 8, 8, 0);
    Optimization run(model, scene, makeConfig(1), {0, 1});
    const StepReport report = run.step();
    EXPECT_GT(report.secondsUpdate, 0);
    EXPECT_EQ(run.state().history.back().secondsUpdate, report.secondsUpdate);
}

// What a mask hides says nothing about how far images are to be trusted.
TEST(Optimize, ThePriorIsBlindToWhatAMaskHides) {
    const auto weight = [](float hidden) {
        OptimizeConfig config = makeConfig(1);
        config.totalVariation = 0;
        config.prior = 5;
        Target& target = config.targets[0];
        target.mask.assign(target.image.pixels(), 1.f);
        for (std::size_t p = 0; p < target.image.pixels() / 2; ++p) {
            target.mask[p] = 0;
            std::fill_n(target.image.values.begin() + std::ptrdiff_t(3 * p), 3, hidden);
        }
        Scene scene = test::makeTruth();
        LinearModel model(scene, 1, 8, 8, 0);
        return Optimization(model, scene, config, {0, 1}).step().regularizer;
    };
    EXPECT_GT(weight(0), 0);
    EXPECT_EQ(weight(0), weight(1000));
}

} // namespace
} // namespace cmpg

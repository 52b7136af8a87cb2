// An image model whose images and derivatives are known: pixel = A p, plus noise that averages out.
#pragma once

#include "optimize/image_model.h"
#include "optimize/optimize.h"
#include "optimize/target.h"
#include "render/pixel_sampling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <random>

namespace cmpg::test {

// Each view has a matrix of its own. Noise of a sample: derivative and value times (1 + noise * N(0,1)).
class LinearModel final : public ImageModel {
  public:
    struct Call {
        char kind; // 'p' primal, 'g' gradient
        std::size_t view;
        PassKey key;
        std::uint64_t samples;
    };

    // Optimises `scene`'s parameters 0 .. n-1, all of them.
    LinearModel(const Scene& scene, std::size_t views, int width, int height, double noise)
        : views_(views), width_(width), height_(height), noise_(noise) {
        for (const Parameter& parameter : scene.parameters)
            parameters_.push_back(parameter.values);
        std::mt19937 random(7);
        std::uniform_real_distribution<double> uniform(0, 1);
        for (std::size_t view = 0; view < views; ++view) {
            // Every pixel value sees two entries of each parameter, the second parameter with changing sign: the matrix is well
            // conditioned, yet not diagonal.
            for (std::size_t i = 0; i < values(); ++i)
                rows_.push_back({0.5 + uniform(random), 0.5 * uniform(random), 2 * uniform(random) - 1, std::uint32_t(random())});
        }
    }

    std::size_t views() const override { return views_; }
    std::pair<int, int> size(std::size_t) const override { return {width_, height_}; }

    Image picture(std::size_t view, std::uint32_t spp, const PassKey& key, bool) override {
        calls.push_back({'p', view, key, spp * std::uint64_t(width_) * height_});
        return image(view, spp, key, parameters_);
    }

    ImageHalves renderHalves(std::size_t view, std::uint32_t spp, const PassKey& key, bool difference, const SampleRanges& samples) override {
        const std::span<const std::uint32_t> counts = samples.counts;
        ImageHalves halves{{}, counts.empty() ? std::max(1u, spp / 2) : *std::max_element(counts.begin(), counts.end()), {counts.begin(), counts.end()}};
        std::uint64_t paths = 0;
        for (std::size_t p = 0; p < std::size_t(width_) * height_; ++p)
            paths += 2 * halves.count(p);
        calls.push_back({'p', view, key, paths});
        std::vector<std::vector<float>> second = parameters_;
        for (std::size_t k = 0; k < second.size(); ++k)
            if (second_.contains(std::uint32_t(k)))
                second[k] = second_.at(std::uint32_t(k));
        for (std::uint32_t h = 0; h < 2; ++h) {
            const PassKey own{key.seed, key.step, key.pass + 5 * h, key.firstSample};
            ImageDifference& half = halves.half[h];
            half.image = image(view, halves.samples, own, parameters_, counts);
            if (!difference)
                continue;
            half.difference = image(view, halves.samples, own, second, counts);
            for (std::size_t i = 0; i < half.image.values.size(); ++i)
                half.difference.values[i] = half.image.values[i] - half.difference.values[i];
        }
        return halves;
    }
    void setSecondValues(std::uint32_t parameter, std::span<const float> v) override { second_[parameter].assign(v.begin(), v.end()); }

    std::uint64_t reverse(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                          std::vector<std::vector<double>>& gradients) override {
        PixelSamples chosen;
        if (pixels == PixelSampling::Adjoint)
            chosen = sampleCounts(adjoint, spp, key);
        std::mt19937_64 random = generator(key);
        std::normal_distribution<double> normal;
        std::uint64_t samples = 0;
        for (std::size_t i = 0; i < values(); ++i) {
            const std::uint32_t count = chosen.counts.empty() ? spp : chosen.counts[i / 3];
            const double weight = chosen.counts.empty() ? 1.0 / spp : chosen.weights[i / 3];
            samples += i % 3 == 0 ? count : 0;
            double mean = 0;
            for (std::uint32_t s = 0; s < count; ++s)
                mean += weight * (1 + noise_ * normal(random));
            for (std::size_t k = 0; k < parameters_.size(); ++k)
                for (const auto& [entry, factor] : terms(view, i, k))
                    gradients[k][entry] += adjoint.values[i] * factor * mean;
        }
        calls.push_back({'g', view, key, samples});
        if (breakGradients)
            breakGradients(gradients);
        return samples;
    }

    std::uint64_t reverseApart(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients,
                               FirstVertices* firstVertices) override {
        verticesAsked += firstVertices != nullptr;
        return reverse(view, spp, key, adjoint, gradients);
    }

    std::uint64_t reverseHalves(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients,
                                std::vector<std::vector<double>>& half) override {
        std::array<std::vector<std::vector<double>>, 2> each;
        std::uint64_t samples = 0;
        for (std::uint32_t h = 0; h < 2; ++h) {
            for (const std::vector<double>& g : gradients)
                each[h].emplace_back(g.size());
            samples += reverse(view, std::max(1u, spp / 2), {key.seed, key.step, key.pass + 5 * h}, adjoint, each[h]);
        }
        for (std::size_t p = 0; p < gradients.size(); ++p)
            for (std::size_t i = 0; i < gradients[p].size(); ++i) {
                gradients[p][i] += 0.5 * (each[0][p][i] + each[1][p][i]);
                half[p][i] += 0.5 * (each[0][p][i] - each[1][p][i]);
            }
        return samples;
    }

    void setParameter(std::uint32_t parameter, std::span<const float> v) override { parameters_.at(parameter).assign(v.begin(), v.end()); }

    std::vector<Call> calls;
    int verticesAsked = 0; // passes that were asked where their camera rays met the scene
    PixelSampling pixels = PixelSampling::Adjoint;
    std::function<void(std::vector<std::vector<double>>&)> breakGradients;
    std::function<void(Image&)> breakImage;
    std::optional<double> secondFactor; // what pixel values answer to the second parameter, times what they answer to the first; none: a factor of its own for each

  private:
    struct Row {
        double own, other, second;
        std::uint32_t pick;
    };
    std::size_t values() const { return std::size_t(width_) * height_ * 3; }

    Image image(std::size_t view, std::uint32_t spp, const PassKey& key, const std::vector<std::vector<float>>& parameters,
                std::span<const std::uint32_t> counts = {}) const {
        std::mt19937_64 random = generator(key);
        std::normal_distribution<double> normal;
        Image image(width_, height_, 3);
        for (std::size_t i = 0; i < values(); ++i) {
            double sum = 0;
            for (std::size_t k = 0; k < parameters.size(); ++k)
                for (const auto& [entry, factor] : terms(view, i, k))
                    sum += factor * parameters[k][entry];
            image.values[i] = float(sum * (1 + noise_ / std::sqrt(double(counts.empty() ? spp : counts[i / 3])) * normal(random)));
        }
        if (breakImage)
            breakImage(image);
        return image;
    }

    // Entries of a parameter a pixel value depends on, with their factors.
    std::array<std::pair<std::size_t, double>, 2> terms(std::size_t view, std::size_t i, std::size_t parameter) const {
        const Row& row = rows_[view * values() + i];
        const std::size_t entries = parameters_[parameter].size();
        const double factor = parameter == 1 ? secondFactor.value_or(row.second) : 1;
        return {{{i % entries, factor * row.own}, {row.pick % entries, factor * row.other}}};
    }

    static std::mt19937_64 generator(const PassKey& key) {
        std::seed_seq seed{std::uint32_t(key.seed), std::uint32_t(key.seed >> 32), key.step, key.pass, key.firstSample};
        return std::mt19937_64(seed);
    }

    std::size_t views_;
    int width_, height_;
    double noise_;
    std::vector<std::vector<float>> parameters_;
    std::map<std::uint32_t, std::vector<float>> second_;
    std::vector<Row> rows_;
};

inline Parameter makeParameter(const std::string& name, SlotKind kind, std::uint32_t width, std::uint32_t height, std::uint32_t channels,
                               float value) {
    Parameter parameter;
    parameter.name = name;
    parameter.kind = kind;
    parameter.width = width;
    parameter.height = height;
    parameter.channels = channels;
    parameter.textured = width * height > 1;
    parameter.values.assign(parameter.entries(), value);
    return parameter;
}

// A texture and a constant that start wrong.
inline Scene makeScene() {
    Scene scene;
    scene.parameters.push_back(makeParameter("wall.baseColor", SlotKind::BaseColor, 4, 4, 3, 0.5f));
    scene.parameters.push_back(makeParameter("lamp.emission", SlotKind::Emission, 1, 1, 3, 1.0f));
    return scene;
}

// The same parameters with values to be found, from 0.2 to `highest`.
inline Scene truthOf(Scene scene, std::uint32_t seed, float highest) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0.2f, highest);
    for (Parameter& parameter : scene.parameters)
        for (float& value : parameter.values)
            value = uniform(random);
    return scene;
}
inline Scene makeTruth() { return truthOf(makeScene(), 3, 0.9f); }

// Noise-free targets of all views of the truth.
inline std::vector<Target> makeTargets(std::size_t views, int width, int height) {
    LinearModel model(makeTruth(), views, width, height, 0);
    std::vector<Target> targets(views);
    for (std::size_t view = 0; view < views; ++view) {
        targets[view].name = "target" + std::to_string(view);
        targets[view].image = model.picture(view, 1, {}, false);
    }
    return targets;
}

inline double rmsError(const Scene& scene) {
    const Scene truth = makeTruth();
    double sum = 0, count = 0;
    for (std::size_t k = 0; k < truth.parameters.size(); ++k)
        for (std::size_t i = 0; i < truth.parameters[k].values.size(); ++i, ++count)
            sum += std::pow(double(scene.parameters[k].values[i]) - truth.parameters[k].values[i], 2);
    return std::sqrt(sum / count);
}

// To the last step of its configuration.
inline void runSteps(Optimization& run, const std::function<void(const StepReport&)>& afterStep = [](const StepReport&) {}) {
    while (run.state().step < run.config().steps)
        afterStep(run.step());
}

} // namespace cmpg::test

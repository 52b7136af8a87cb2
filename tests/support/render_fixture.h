// A device and a bundled scene for the tests of the renderer.
#pragma once

#include "render/renderer.h"
#include "scene/scene_file.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace cmpg::test {

// One device for all tests of a process. Kernels are kept: not every driver caches their compilation.
inline Device& device() {
    static Device d = [] {
        Device made{Device::Options{}};
        made.keepKernels();
        return made;
    }();
    return d;
}

inline Scene bundledScene(const std::string& name) { return loadScene(std::filesystem::path(CMPG_SOURCE_DIR "/scenes") / name / "scene.gltf"); }

inline View viewOf(const Scene& scene, int width, int height) { return View{&scene.cameras.front(), width, height}; }

struct Bench {
    Scene scene;
    RenderConfig config;
    std::unique_ptr<Renderer> renderer;
    PassPlan plan;     // of the passes that tests make with it
    PassResult result; // of the last

    Bench(Scene s, const std::vector<std::string>& globs, RenderConfig c = {}, Device& on = device()) : scene(std::move(s)), config(c) {
        for (const std::string& glob : globs)
            for (const std::uint32_t p : scene.select(glob))
                config.differentiable.push_back(p);
        renderer = std::make_unique<Renderer>(on, scene, config);
    }
    std::vector<std::vector<float>> ones() const {
        std::vector<std::vector<float>> v;
        for (const std::uint32_t p : config.differentiable)
            v.emplace_back(scene.parameters[p].entries(), 1.0f);
        return v;
    }
};

struct MeanError {
    double mean = 0, standardError = 0;
    std::size_t estimates = 0; // that the error was found from
};

// Mean of independent estimates and its standard error.
inline MeanError statistics(const std::vector<double>& estimates) {
    double sum = 0, squares = 0;
    for (const double e : estimates)
        sum += e;
    const double mean = sum / double(estimates.size());
    for (const double e : estimates)
        squares += (e - mean) * (e - mean);
    return {mean, std::sqrt(squares / double(estimates.size() - 1) / double(estimates.size())), estimates.size()};
}

inline double meanOf(const Image& image) {
    double sum = 0;
    for (const float v : image.values)
        sum += v;
    return sum / double(image.values.size());
}

// 24 x 24 pixels of 16 samples.
inline Image smallImage(Scene scene) {
    Bench s(std::move(scene), {});
    return s.renderer->render(viewOf(s.scene, 24, 24), 16, {3, 0, 0});
}

// Mean absolute difference over the mean absolute value of `reference`.
inline double relativeDifference(const Image& image, const Image& reference) {
    double off = 0, size = 0;
    for (std::size_t i = 0; i < image.values.size(); ++i) {
        off += std::abs(double(image.values[i]) - reference.values[i]);
        size += std::abs(reference.values[i]);
    }
    return off / size;
}

} // namespace cmpg::test

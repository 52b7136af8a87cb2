// The cost of an optimisation step and of its passes, and how much of it is spent outside kernels.
#include "bench.h"

#include "base/stopwatch.h"
#include "median.h"
#include "optimize/optimize.h"
#include "optimize/renderer_model.h"
#include "scene/scene_file.h"

#include <cstdio>

namespace cmpg::bench {

namespace {

double kernelSeconds(const Device& device) {
    double sum = 0;
    for (const auto& [name, time] : device.kernelTimes())
        sum += time.seconds;
    return sum;
}

} // namespace

void step(const std::string& scenes) {
    constexpr int kSize = 256, kRepeats = 7;
    std::printf("\nPasses and steps at %d x %d, medians of %d interleaved runs\n", kSize, kSize, kRepeats);
    std::printf("%-10s %14s %16s %12s %22s\n", "scene", "image s/spp", "gradient s/spp", "ratio", "step outside kernels");
    for (const auto& [name, parameter] : {std::pair{"box", "painting.baseColor"}, {"door", "painting.baseColor"}, {"bowl", "table.baseColor"}}) {
        Device device{Device::Options{}};
        Scene scene = loadScene(scenes + "/" + name + "/scene.gltf");
        RenderConfig config;
        config.differentiable = {scene.parameter(parameter)};
        config.maxDepth = scene.maxDepth;
        Renderer renderer(device, scene, config);
        renderer.prepare({Renderer::Mode::Render, Renderer::Mode::Reverse});
        const View view{&scene.cameras.front(), kSize, kSize};
        const Image adjoint(kSize, kSize, 3, 1e-5f);

        // Equal samples: the image against the whole derivative pass, uniform pixels.
        std::vector<double> primal, derivative;
        for (std::uint32_t i = 0; i < kRepeats; ++i) {
            const Stopwatch image;
            renderer.render(view, 8, {i, 0, 0});
            primal.push_back(image.seconds() / 8);
            std::vector<std::vector<double>> gradients;
            const Stopwatch gradient;
            renderer.reverse(view, 8, {i, 0, 1}, adjoint, {}, {}, gradients);
            derivative.push_back(gradient.seconds() / 8);
        }

        // A whole step, 16 + 4 samples per pixel: what is not inside a kernel's time stamps.
        OptimizeConfig optimize;
        optimize.steps = kRepeats;
        Target target;
        target.image = Image(kSize, kSize, 3, 0.5f);
        optimize.targets.push_back(target);
        GuidedPasses passes(renderer, {.sampling = Sampling::Bsdf, .roulette = false});
        RendererModel model(renderer, passes, {view});
        Optimization optimization(model, scene, optimize, config.differentiable);
        std::vector<double> outside;
        for (int i = 0; i < kRepeats; ++i) {
            device.resetKernelTimes();
            const Stopwatch watch;
            optimization.step();
            const double wall = watch.seconds();
            outside.push_back((wall - kernelSeconds(device)) / wall);
        }
        std::printf("%-10s %14.4f %16.4f %12.2f %20.1f %%\n", name, median(primal), median(derivative), median(derivative) / median(primal),
                    100 * median(outside));
    }
}

} // namespace cmpg::bench

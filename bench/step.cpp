// The cost of an optimisation step and of its passes, and how much of it is spent outside kernels.
#include "bench.h"

#include "median.h"

#include <cmpg/recovery.h>

#include <cstdio>

namespace cmpg::bench {

void step(const std::string& scenes) {
    constexpr int kSize = 256, kRepeats = 7;
    constexpr std::uint32_t kSpp = 8;
    std::printf("\nPasses and steps at %d x %d, medians of %d interleaved runs\n", kSize, kSize, kRepeats);
    std::printf("%-10s %14s %16s %12s %22s\n", "scene", "image s/spp", "gradient s/spp", "ratio", "step outside kernels");
    for (const auto& [name, parameter] : {std::pair{"box", "painting.baseColor"}, {"door", "painting.baseColor"}, {"bowl", "table.baseColor"}}) {
        v1::Device device;
        const v1::Scene scene = v1::Scene::load(scenes + "/" + name + "/scene.gltf");
        v1::PathOptions unguided{.sampling = Sampling::Bsdf, .pixelSampling = PixelSampling::Uniform, .roulette = false};
        v1::Renderer renderer(device, scene, {.paths = unguided, .parameters = {parameter}});
        v1::PassOptions pass{.width = kSize, .height = kSize, .spp = kSpp};
        renderer.prepare({v1::PassKind::Render, v1::PassKind::Backward}, pass);
        const Image adjoint(kSize, kSize, 3, 1e-5f);

        // Equal samples: the image against the whole derivative pass, uniform pixels.
        std::vector<double> primal, derivative;
        for (pass.seed = 0; pass.seed < kRepeats; ++pass.seed) {
            v1::PassReport image, gradient;
            renderer.render(pass, &image);
            primal.push_back(image.seconds / kSpp);
            renderer.backward(adjoint, pass, &gradient);
            derivative.push_back(gradient.seconds / kSpp);
        }

        // A whole step, 16 + 4 samples per pixel: what is not inside a kernel's time stamps.
        unguided.pixelSampling = PixelSampling::Adjoint;
        v1::RecoveryOptions options{.paths = unguided, .parameters = {parameter}, .steps = kRepeats, .sppDifference = 2, .optimizer = OptimizerKind::Adam, .prior = 0};
        v1::Recovery recovery(device, scene, {{.image = Image(kSize, kSize, 3, 0.5f)}}, options);
        device.timeKernels();
        std::vector<double> outside;
        for (int i = 0; i < kRepeats; ++i) {
            const double before = device.kernelSeconds(), wall = recovery.step().seconds;
            outside.push_back((wall - (device.kernelSeconds() - before)) / wall);
        }
        std::printf("%-10s %14.4f %16.4f %12.2f %20.1f %%\n", name, median(primal), median(derivative), median(derivative) / median(primal),
                    100 * median(outside));
        std::fflush(stdout);
    }
}

} // namespace cmpg::bench

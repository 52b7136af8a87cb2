// What leaving out the features a scene does not need saves: time of passes, and of a start for which no compiled kernel is stored.
#include "bench.h"

#include "median.h"

#include <cmpg/renderer.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <sys/resource.h>

namespace cmpg::bench {

namespace {

constexpr int kSize = 128, kRepeats = 7, kStarts = 5;
constexpr std::uint32_t kSpp = 8;

// Of all threads of this process: other programs on the machine count less in it than in wall time.
double processorSeconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Taken {
    double wall = 0, processor = 0;
};

template <class Work> Taken timed(Work&& work) {
    const double before = processorSeconds();
    const auto start = std::chrono::steady_clock::now();
    work();
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), processorSeconds() - before};
}

struct Subject {
    v1::Renderer renderer;
    v1::PassOptions pass;
    Image adjoint;

    Subject(const v1::Device& device, const std::string& file, const char* parameter, bool everything, int size)
        : renderer(device, v1::Scene::load(file), options(parameter, everything)), pass{.width = size, .height = size, .seed = 1}, adjoint(size, size, 3, 1e-5f) {}

    static v1::RendererOptions options(const char* parameter, bool everything) {
        v1::RendererOptions o;
        o.paths = {.sampling = Sampling::Bsdf, .pixelSampling = PixelSampling::Uniform, .roulette = false};
        o.paths.allFeatures = everything;
        if (parameter)
            o.parameters = {parameter};
        return o;
    }
    v1::PassOptions passOf(std::uint32_t spp, std::uint32_t frame) const {
        v1::PassOptions own = pass;
        own.spp = spp;
        own.frame = frame;
        return own;
    }
    void image(std::uint32_t spp, std::uint32_t frame) { renderer.render(passOf(spp, frame)); }
    void gradient(std::uint32_t spp, std::uint32_t frame) { renderer.backward(adjoint, passOf(spp, frame)); }
};

// Both variants in turn; prints their medians and ratios. `work(everything, run)` measures one.
template <class Work> void compare(const char* scene, const char* what, int repeats, Work&& work) {
    std::array<std::vector<double>, 2> wall, processor;
    for (int run = 0; run < repeats; ++run)
        for (const bool everything : {false, true}) {
            const Taken t = work(everything, std::uint32_t(run));
            wall[everything].push_back(t.wall);
            processor[everything].push_back(t.processor);
        }
    const double w[] = {median(wall[0]), median(wall[1])}, p[] = {median(processor[0]), median(processor[1])};
    std::printf("%-12s %-14s %10.3f %10.3f %8.2f %14.3f %10.3f %8.2f\n", scene, what, w[0], w[1], w[1] / w[0], p[0], p[1], p[1] / p[0]);
    std::fflush(stdout);
}

void passes(const char* name, const std::string& file, const char* parameter) {
    const v1::Device device;
    Subject own(device, file, parameter, false, kSize), all(device, file, parameter, true, kSize);
    const auto subject = [&](bool everything) -> Subject& { return everything ? all : own; };
    for (const bool everything : {false, true}) { // compiles
        subject(everything).image(1, 0);
        subject(everything).gradient(1, 0);
    }
    compare(name, "image", kRepeats, [&](bool everything, std::uint32_t run) { return timed([&] { subject(everything).image(kSpp, run); }); });
    compare(name, "gradient", kRepeats, [&](bool everything, std::uint32_t run) { return timed([&] { subject(everything).gradient(kSpp, run); }); });
}

// From nothing to a first small result.
void starts(const char* name, const std::string& file, const char* parameter) {
    for (const bool gradient : {false, true}) {
        std::array<std::map<std::string, double>, 2> compile;
        compare(name, gradient ? "start, gradient" : "start, image", kStarts, [&](bool everything, std::uint32_t run) {
            return timed([&] {
                const v1::Device device;
                Subject s(device, file, gradient ? parameter : nullptr, everything, 16);
                if (gradient)
                    s.gradient(1, run);
                else
                    s.image(1, run);
                compile[everything] = device.compileSeconds();
            });
        });
        std::printf("    compilation:");
        for (const auto& [kernel, seconds] : compile[1])
            std::printf("  %s %.2f / %.2f", kernel.c_str(), compile[0][kernel], seconds);
        std::printf("\n");
    }
}

} // namespace

void features(const std::string& scenes) {
    setenv("MESA_SHADER_CACHE_DISABLE", "true", 1); // read when a device is made
    setenv("CMPG_CACHE", "0", 1);
    std::printf("\nOnly what a scene requires, against all features: medians of seconds, and ratios\n");
    std::printf("%-12s %-14s %10s %10s %8s %14s %10s %8s\n", "scene", "what", "own", "all", "ratio", "processor: own", "all", "ratio");
    { const v1::Device first; } // what the driver does once in a process
    for (const auto& [name, parameter] : {std::pair{"box", "painting.baseColor"}, {"materials", "varied.baseColor"}}) {
        const std::string file = scenes + "/" + name + "/scene.gltf";
        starts(name, file, parameter);
        passes(name, file, parameter);
    }
    unsetenv("MESA_SHADER_CACHE_DISABLE");
    unsetenv("CMPG_CACHE");
}

} // namespace cmpg::bench

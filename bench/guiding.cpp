// What guiding costs: passes drawn from a guide against unguided ones, and the rebuild on the host as a share of a step.
#include "bench.h"

#include "base/stopwatch.h"
#include "median.h"
#include "render/renderer.h"
#include "scene/scene_file.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace cmpg::bench {

namespace {

constexpr std::uint32_t kSpp = 4;

struct Subject {
    Device device{Device::Options{}};
    Scene scene;
    Renderer renderer;
    View view;
    Image adjoint;
    PassResult last;

    Subject(const std::string& file, const std::string& parameter, int size, const SdTreeConfig& tree)
        : scene(loadScene(file)), renderer(device, scene, config(parameter, tree)), view{&scene.cameras.front(), size, size},
          adjoint(size, size, 3, 1e-5f) {}

    RenderConfig config(const std::string& parameter, const SdTreeConfig& tree) {
        RenderConfig c;
        c.differentiable = {scene.parameter(parameter)};
        c.maxDepth = scene.maxDepth;
        c.guiding = true;
        c.guide = tree;
        c.guideMemory = std::uint64_t(256) << 20;
        return c;
    }
    double reverse(const PassPlan& plan, std::uint32_t spp, std::uint32_t step) {
        std::vector<std::vector<double>> gradients;
        const Stopwatch watch;
        last = renderer.reverse(view, spp, {1, step, 1}, adjoint, {}, {}, gradients, plan);
        return watch.seconds();
    }
    double render(const PassPlan& plan, std::uint32_t spp, std::uint32_t step) {
        const Stopwatch watch;
        renderer.render(view, spp, {1, step, 0}, plan);
        return watch.seconds();
    }
};

void passes(const char* name, const std::string& file, const std::string& parameter) {
    constexpr int kSize = 256, kRepeats = 7, kTrain = 8;
    Subject s(file, parameter, kSize, {});
    for (std::uint32_t i = 0; i < kTrain; ++i) {
        s.reverse({.method = {Sampling::Conditional}, .record = true}, kSpp, i);
        s.renderer.updateGuide();
    }
    const PassPlan plans[] = {{}, {.method = {Sampling::Conditional}}, {.method = {Sampling::Conditional}, .record = true}};
    std::vector<double> times[3];
    double rays[3] = {};
    for (std::uint32_t i = 0; i <= kRepeats; ++i)
        for (int w = 0; w < 3; ++w) {
            const double t = s.reverse(plans[w], kSpp, 100 + i);
            rays[w] = double(s.last.rays) / double(s.last.paths);
            if (i > 0) // the first compiles
                times[w].push_back(t);
        }
    const double plain = median(times[0]), guided = median(times[1]), recorded = median(times[2]);
    std::printf("%-10s %12.4f %12.2f %12.2f %14.2f %14.2f\n", name, plain / kSpp, guided / plain, recorded / plain, rays[1] / rays[0],
                (guided / rays[1]) / (plain / rays[0]));
}

// One step of 16 + 4 samples per pixel that learns, after `before` others.
void rebuild(const char* name, const std::string& file, int size, std::uint32_t before, std::uint32_t cellRecords) {
    SdTreeConfig tree;
    tree.cellRecords = cellRecords;
    tree.maxNodes = std::uint64_t(1) << 24;
    Subject s(file, "painting.baseColor", size, tree);
    const PassPlan plan{.method = {Sampling::Conditional}, .record = true};
    double wall = 0, host = 0;
    for (std::uint32_t i = 0; i <= before; ++i) {
        const double primal = s.render(plan, i == before ? 16 : 2, i), derivative = s.reverse(plan, i == before ? 4 : 2, i);
        const Stopwatch watch;
        s.renderer.updateGuide();
        host = watch.seconds();
        wall = primal + derivative + host;
    }
    std::printf("%-10s %6d %8zu cells %8llu nodes %10.1f ms %8.2f %% of the step\n", name, size, s.renderer.guide().cells().size(),
                static_cast<unsigned long long>(s.renderer.guide().nodes()), 1e3 * host, 100 * host / wall);
}

} // namespace

void guiding(const std::string& scenes) {
    const std::string made = (std::filesystem::temp_directory_path() / "cmpg-vk-bench-room").string(); // large, so not stored
    const bool hasRoom = std::system(("python3 \"" + scenes + "/generate.py\" room -o \"" + made + "\" > /dev/null").c_str()) == 0;
    std::printf("\nDerivative passes at 256 x 256, %u samples: unguided s/spp; conditional, and with records, against it; rays; time per ray\n", kSpp);
    std::printf("%-10s %12s %12s %12s %14s %14s\n", "scene", "unguided", "guided", "recorded", "rays", "time per ray");
    passes("box", scenes + "/box/scene.gltf", "painting.baseColor");
    passes("door", scenes + "/door/scene.gltf", "painting.baseColor");
    passes("bowl", scenes + "/bowl/scene.gltf", "table.baseColor");
    if (hasRoom)
        passes("room", made + "/scene.gltf", "painting.baseColor");
    std::printf("\nRebuilding the tree on the host, transfers included\n");
    rebuild("door", scenes + "/door/scene.gltf", 256, 29, SdTreeConfig{}.cellRecords);
    rebuild("door", scenes + "/door/scene.gltf", 1024, 5, 1000);
}

} // namespace cmpg::bench

// What guiding costs: passes drawn from a guide against unguided ones, and the rebuild on the host as a share of a step.
#include "bench.h"

#include "median.h"

#include <cmpg/recovery.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace cmpg::bench {

namespace {

constexpr std::uint32_t kSpp = 4;

v1::PathOptions pathsBy(Sampling sampling) {
    return {.sampling = sampling, .pixelSampling = PixelSampling::Uniform, .roulette = false, .guideMemory = 256, .guide = {.keep = true}};
}

void passes(const char* name, const std::string& file, const std::string& parameter) {
    constexpr int kSize = 256, kRepeats = 7;
    constexpr std::uint32_t kTrain = 8;
    const v1::Device device;
    const v1::Scene scene = v1::Scene::load(file);
    const Image adjoint(kSize, kSize, 3, 1e-5f);
    v1::Renderer plain(device, scene, {.paths = pathsBy(Sampling::Bsdf), .parameters = {parameter}});
    v1::Renderer guided(device, scene, {.paths = pathsBy(Sampling::Conditional), .parameters = {parameter}});
    guided.backward(adjoint, {.spp = kSpp, .seed = 1, .train = kTrain});
    std::vector<double> times[3];
    double rays[2] = {};
    for (std::uint32_t i = 0; i <= kRepeats; ++i) {
        const v1::PassOptions pass{.spp = kSpp, .seed = 1, .frame = 100 + i};
        v1::PassReport reports[3];
        plain.backward(adjoint, pass, &reports[0]);
        guided.backward(adjoint, pass, &reports[1]);
        v1::PassOptions learning = pass;
        learning.seed += 100 + i;
        learning.train = 1;
        learning.anew = false;
        guided.backward(adjoint, learning, &reports[2]);
        for (int w = 0; w < 2; ++w)
            rays[w] = double(reports[w].rays) / double(reports[w].paths);
        if (i == 0) // compiles
            continue;
        times[0].push_back(reports[0].seconds);
        times[1].push_back(reports[1].seconds);
        times[2].push_back(reports[2].learningSeconds);
    }
    const double unguided = median(times[0]), drawn = median(times[1]), learned = median(times[2]);
    std::printf("%-10s %12.4f %12.2f %12.2f %14.2f %14.2f\n", name, unguided / kSpp, drawn / unguided, learned / unguided, rays[1] / rays[0],
                (drawn / rays[1]) / (unguided / rays[0]));
    std::fflush(stdout);
}

// One step of 16 + 4 samples per pixel that learns, after `before` others.
void rebuild(const char* name, const std::string& file, int size, std::uint32_t before, std::uint32_t cellRecords) {
    v1::RecoveryOptions options{.paths = pathsBy(Sampling::Conditional), .parameters = {"painting.baseColor"}, .spp = 2, .sppGradient = 2, .sppDifference = 0, .prior = 0};
    if (cellRecords > 0)
        options.paths.guide.cellRecords = cellRecords;
    v1::Recovery recovery(v1::Device(), v1::Scene::load(file), {{.image = Image(size, size, 3, 0.5f)}}, options);
    for (std::uint32_t i = 0; i < before; ++i)
        recovery.step();
    recovery.setSamples(16, 4);
    const double learned = recovery.report().learningSeconds; // in a recovery: what rebuilding took
    const v1::RecoveryStep step = recovery.step();
    const v1::PassReport report = recovery.report();
    const double host = report.learningSeconds - learned;
    std::printf("%-10s %6d %8u cells %10.1f ms %8.2f %% of the step\n", name, size, report.guideCells, 1e3 * host, 100 * host / step.seconds);
    std::fflush(stdout);
}

} // namespace

void guiding(const std::string& scenes) {
    const std::string made = (std::filesystem::temp_directory_path() / "cmpg-vk-bench-room").string(); // large, so not stored
    const bool hasRoom = std::system(("python3 \"" + scenes + "/generate.py\" room -o \"" + made + "\" > /dev/null").c_str()) == 0;
    std::printf("\nDerivative passes at 256 x 256, %u samples: unguided s/spp; conditional, and learning with the rebuild, against it; rays; time per ray\n", kSpp);
    std::printf("%-10s %12s %12s %12s %14s %14s\n", "scene", "unguided", "guided", "learning", "rays", "time per ray");
    passes("box", scenes + "/box/scene.gltf", "painting.baseColor");
    passes("door", scenes + "/door/scene.gltf", "painting.baseColor");
    passes("bowl", scenes + "/bowl/scene.gltf", "table.baseColor");
    if (hasRoom)
        passes("room", made + "/scene.gltf", "painting.baseColor");
    std::printf("\nRebuilding the tree on the host, transfers included\n");
    rebuild("door", scenes + "/door/scene.gltf", 256, 29, 0);
    rebuild("door", scenes + "/door/scene.gltf", 1024, 5, 1000);
}

} // namespace cmpg::bench

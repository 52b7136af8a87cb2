// Camera rays and two diffuse bounces through generated scenes: our kernels against Embree's rtcIntersect1, both on two threads.
// Single rays and the hierarchy are nothing that include/cmpg shows, so this part alone builds on folders behind it, by the tests' support.
#include "bench.h"

#include "base/stopwatch.h"
#include "median.h"
#include "support/embree_scene.h"
#include "support/generated_geometry.h"
#include "support/tracer.h"

#include <cstdio>

namespace cmpg::bench {
namespace {

constexpr std::uint32_t kImage = 1024; // pixels along an edge
constexpr int kRepetitions = 7;

struct View {
    glm::vec3 eye, direction;
};

// One ray a pixel; pixels in tiles of 8 x 8, inside a tile in Morton order, so that neighbours in memory are neighbours in the image.
std::vector<gpu::Ray> cameraRays(const View& view) {
    const glm::vec3 right = glm::normalize(glm::cross(view.direction, glm::vec3(0, 1, 0))), up = glm::cross(right, view.direction);
    generated::Random random(1);
    std::vector<gpu::Ray> rays(kImage * kImage);
    for (std::uint32_t i = 0; i < rays.size(); ++i) {
        const std::uint32_t tile = i / 64, x = (i & 1) | (i >> 1 & 2) | (i >> 2 & 4), y = (i >> 1 & 1) | (i >> 2 & 2) | (i >> 3 & 4);
        const float u = (float(tile % (kImage / 8) * 8 + x) + random.uniform()) / kImage;
        const float v = (float(tile / (kImage / 8) * 8 + y) + random.uniform()) / kImage;
        rays[i] = {view.eye, i, glm::normalize(view.direction + 0.8f * ((2 * u - 1) * right + (1 - 2 * v) * up)), 0};
    }
    return rays;
}

// A cosine-distributed ray from every hit, in the order of the hits.
std::vector<gpu::Ray> bounce(const std::vector<gpu::Ray>& rays, const std::vector<test::EmbreeScene::Answer>& hits, std::uint32_t seed) {
    generated::Random random(seed);
    std::vector<gpu::Ray> next;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (hits[i].t < 0)
            continue;
        const glm::vec3 n = glm::normalize(hits[i].normal), facing = glm::dot(n, rays[i].direction) > 0 ? -n : n;
        const glm::vec3 p = rays[i].origin + hits[i].t * rays[i].direction;
        next.push_back({p + 1e-4f * facing, std::uint32_t(i), glm::normalize(random.direction() + 1.0001f * facing), 0});
    }
    return next;
}

void scene(Device& device, const char* name, const Geometry& geometry, const View& view) {
    std::vector<double> build;
    for (int i = 0; i < kRepetitions; ++i) {
        const Stopwatch watch;
        buildBvh(geometry);
        build.push_back(watch.seconds());
    }
    const Bvh bvh = buildBvh(geometry);
    std::printf("\n%s: %zu triangles, built at %.2f M triangles/s, %zu records, expected records a line %.1f\n", name, geometry.triangles.size(),
                double(geometry.triangles.size()) / median(build) * 1e-6, bvh.records.size(), double(bvh.sahCost));
    std::printf("%-14s %10s %14s %14s   (M rays/s, in brackets the ratio to Embree)\n", "", "Embree", "ours", "shadow rays");

    const test::EmbreeScene embree(geometry, false);
    test::Tracer tracer(device, bvh, bvh.depth);
    std::vector<gpu::Ray> rays = cameraRays(view);
    for (const char* kind : {"camera", "first bounce", "second bounce"}) {
        const auto hits = embree.intersect(rays);
        std::vector<gpu::ShadowRay> shadowRays;
        for (std::size_t i = 0; i < rays.size(); ++i) // each to a point before or behind the nearest hit
            shadowRays.push_back({rays[i].origin, std::max(0.f, hits[i].t) * (i % 2 ? 0.9f : 1.1f), rays[i].direction, 0});
        std::vector<double> theirs, ours, shadow;
        for (int i = 0; i < kRepetitions; ++i) {
            const Stopwatch watch;
            embree.intersect(rays);
            theirs.push_back(watch.seconds());
            tracer.closest(rays);
            ours.push_back(tracer.seconds());
            tracer.visible(shadowRays);
            shadow.push_back(tracer.seconds());
        }
        const auto rate = [&](const std::vector<double>& seconds) { return double(rays.size()) / median(seconds) * 1e-6; };
        std::printf("%-14s %10.2f %7.2f (%.2f) %7.2f (%.2f)\n", kind, rate(theirs), rate(ours), rate(ours) / rate(theirs), rate(shadow),
                    rate(shadow) / rate(theirs));
        rays = bounce(rays, hits, 2);
    }
}

} // namespace

void traversal() {
    Device device(Device::Options{});
    device.timeKernels(true);
    std::printf("Traversal on %s, %u driver threads, against Embree rtcIntersect1 on 2 threads; medians of %d\n", device.info().name.c_str(),
                device.driverThreads(), kRepetitions);
    scene(device, "Furnished room", generated::room(), {{-2.2f, 1.7f, 2.2f}, glm::normalize(glm::vec3(0.6f, -0.3f, -0.75f))});
    scene(device, "Box", generated::box(), {{0, 0, 0.95f}, {0, 0, -1}});
    scene(device, "Soup", generated::soup(1'000'000, 0.01f, 5), {{0.5f, 0.5f, -1.2f}, {0, 0, 1}});
}

} // namespace cmpg::bench

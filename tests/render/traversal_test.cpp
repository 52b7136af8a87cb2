// The tracing kernels against Embree on generated scenes.
#include "support/embree_scene.h"
#include "support/generated_geometry.h"
#include "support/tracer.h"

#include <gtest/gtest.h>

namespace cmpg {
namespace {

using generated::Random;

Device& device(bool portable) {
    static Device full(Device::Options{}), plain(Device::Options{.select = {}, .validation = false, .portable = true});
    return portable ? plain : full;
}

// Origins all over the geometry's bounding box enlarged by a tenth, directions uniform on the sphere.
std::vector<gpu::Ray> randomRays(const Geometry& g, std::uint32_t count, std::uint32_t seed) {
    glm::vec3 low(std::numeric_limits<float>::infinity()), high(-low);
    for (const glm::vec3& p : g.positions)
        low = glm::min(low, p), high = glm::max(high, p);
    const glm::vec3 margin = 0.1f * (high - low);
    Random random(seed);
    std::vector<gpu::Ray> rays(count);
    for (gpu::Ray& r : rays) {
        r.origin = random.inBox(low - margin, high + margin);
        r.direction = random.direction();
    }
    return rays;
}

// Distance to a triangle's plane in double precision.
double exactDistance(const Geometry& g, std::uint32_t triangle, const gpu::Ray& ray) {
    const auto& v = g.triangles[triangle].vertices;
    const glm::dvec3 a = g.positions[v[0]], b = g.positions[v[1]], c = g.positions[v[2]];
    const glm::dvec3 normal = cross(b - a, c - a);
    return dot(a - glm::dvec3(ray.origin), normal) / dot(glm::dvec3(ray.direction), normal);
}

glm::vec3 hitPoint(const Geometry& g, const Bvh& bvh, const gpu::Hit& hit) {
    const auto& v = g.triangles[bvh.order[hit.triangle]].vertices;
    return g.positions[v[0]] * (1 - hit.barycentrics.x - hit.barycentrics.y) + g.positions[v[1]] * hit.barycentrics.x +
           g.positions[v[2]] * hit.barycentrics.y;
}

struct Setup {
    bool portable = false;
    std::uint32_t depth = 0; // at least, that the kernels are told of
    bool needles = false; // float barycentrics along a needle are as inexact as the needle is thin
};

// Nearest hits agree with Embree's in all but 1e-5 of the rays (edges that two roundings see on different sides); barycentrics lead
// to the same point as the distance; any-hit rays see exactly what nearest hits say. Distances may differ by 1e-4 of themselves, and
// by the rounding of the positions. Where they differ more on one triangle, double precision settles it: Embree is wrong on needles.
void compare(const Geometry& g, const std::vector<gpu::Ray>& rays, Setup setup = {}) {
    const Bvh bvh = buildBvh(g);
    const test::EmbreeScene embree(g, true);
    test::Tracer tracer(device(setup.portable), bvh, std::max(setup.depth, bvh.depth));
    const auto expected = embree.intersect(rays);
    const auto hits = tracer.closest(rays);
    EXPECT_EQ(tracer.unfinished(), 0u);

    float reach = 0; // largest coordinate
    for (const glm::vec3& p : g.positions)
        reach = std::max({reach, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    const auto agree = [&](float t, double reference) { return std::abs(double(t) - reference) <= 1e-4 * reference + 6e-8 * double(reach); };

    std::size_t met = 0, disagreements = 0, misplaced = 0;
    std::vector<gpu::ShadowRay> shadowRays(rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const gpu::Ray& ray = rays[i];
        const gpu::Hit& hit = hits[i];
        met += expected[i].t >= 0;
        const bool ours = hit.t >= 0, theirs = expected[i].t >= 0;
        const std::uint32_t triangle = ours ? bvh.order.at(hit.triangle) : ~0u;
        const bool same = ours && theirs
                              ? agree(hit.t, double(expected[i].t)) ||
                                    (triangle == expected[i].triangle && agree(hit.t, exactDistance(g, triangle, ray)))
                              : ours == theirs;
        if (!same && ++disagreements <= 10)
            std::printf("ray %zu: Embree %.9g, triangle %u; ours %.9g, triangle %u\n", i, double(expected[i].t), expected[i].triangle,
                        double(hit.t), triangle);
        if (ours && !setup.needles) {
            const glm::vec3 p = ray.origin + hit.t * ray.direction;
            // Rounding of the point itself, a few units in the last place of the largest numbers involved.
            const float scale = glm::length(ray.origin) + hit.t + glm::length(p);
            misplaced += glm::length(hitPoint(g, bvh, hit) - p) > 4e-6f * scale;
        }
        // Just before and just behind the nearest hit, far beyond it, anywhere.
        const float factors[] = {0.999f, 1.001f, 10.f, 0.5f};
        shadowRays[i] = {ray.origin, hit.t >= 0 ? hit.t * factors[i % 4] : float(i % 7), ray.direction, std::uint32_t(i)};
    }
    EXPECT_GT(met, rays.size() / 100) << "the rays must test something";
    EXPECT_LE(disagreements, rays.size() / 100'000) << "of " << rays.size() << " rays";
    EXPECT_LE(misplaced, rays.size() / 100'000) << "barycentrics and distance lead to different points";

    const auto visible = tracer.visible(shadowRays);
    EXPECT_EQ(tracer.unfinished(), 0u);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < rays.size(); ++i)
        wrong += visible[i] != (hits[i].t >= 0 && hits[i].t < shadowRays[i].distance ? 0u : 1u);
    EXPECT_EQ(wrong, 0u) << "shadow rays that contradict the nearest hit";
}

constexpr std::uint32_t kRays = 1'000'000;

TEST(Traversal, Box) {
    const Geometry g = generated::box();
    compare(g, randomRays(g, kRays, 1));
}

TEST(Traversal, Soup) {
    const Geometry g = generated::soup(100'000, 0.02f, 2);
    compare(g, randomRays(g, kRays, 2));
}

// Rays meet most of the slivers' boxes, and take seven times as long as in a room.
void traceSlivers(std::uint32_t rays) {
    const Geometry g = generated::slivers(5000, 3);
    compare(g, randomRays(g, rays, 3), {.needles = true});
}

TEST(Traversal, Slivers) { traceSlivers(kRays / 4); }
TEST(Traversal, FullSlivers) { traceSlivers(kRays); }

TEST(Traversal, Room) {
    const Geometry g = generated::room();
    ASSERT_GE(g.triangles.size(), 250'000u);
    compare(g, randomRays(g, kRays, 4));
}

TEST(Traversal, FullMillionTriangles) {
    const Geometry g = generated::soup(1'000'000, 0.01f, 5);
    compare(g, randomRays(g, kRays, 5));
}

// The other variants of the kernels do the same arithmetic; fewer rays suffice.
TEST(Traversal, Variants) {
    const Geometry g = generated::room(0.3f);
    const auto rays = randomRays(g, 200'000, 6);
    for (const bool portable : {false, true}) {
        compare(g, rays, {.portable = portable});
        compare(g, rays, {.portable = portable, .depth = gpu::kMaxBvhDepth}); // the stack in an array
    }
}

TEST(Traversal, FewTriangles) {
    Geometry g;
    const std::vector<gpu::Ray> rays{{{0.2f, 0.2f, 1}, 0, {0, 0, -1}, 0}, {{0.2f, 0.2f, 1}, 0, {0, 0, 1}, 0}};
    EXPECT_LT(test::Tracer(device(false), buildBvh(g), 1).closest(rays)[0].t, 0) << "an empty scene";
    generated::addTriangle(g, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    for (int triangles = 1; triangles <= 9; ++triangles) {
        const Bvh bvh = buildBvh(g);
        test::Tracer tracer(device(false), bvh, bvh.depth);
        const auto hits = tracer.closest(rays);
        EXPECT_EQ(hits[0].t, 1.f) << triangles << " triangles";
        EXPECT_LT(hits[1].t, 0.f) << triangles << " triangles";
        generated::addTriangle(g, {0, 0, -float(triangles)}, {1, 0, -float(triangles)}, {0, 1, -float(triangles)});
    }
}

// Every ray aims at a vertex or an edge of a closed surface from inside: none may slip out, and Embree's fast mode would lose some.
TEST(Traversal, RaysDoNotSlipBetweenNeighbours) {
    Geometry g;
    generated::addSphere(g, {10, -3, 5}, glm::vec3(1, 1.5f, 0.8f), 40);
    Random random(8);
    std::vector<gpu::Ray> rays(kRays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const auto& v = g.triangles[i % g.triangles.size()].vertices;
        const glm::vec3 a = g.positions[v[i % 3]], b = g.positions[v[(i + 1) % 3]];
        const glm::vec3 origin = glm::vec3(10, -3, 5) + 0.5f * random.uniform() * random.direction();
        rays[i].origin = origin;
        rays[i].direction = glm::normalize(glm::mix(a, b, i % 2 ? random.uniform() : 0.f) - origin);
    }
    const Bvh bvh = buildBvh(g);
    test::Tracer tracer(device(false), bvh, bvh.depth);
    const auto hits = tracer.closest(rays);
    EXPECT_EQ(std::count_if(hits.begin(), hits.end(), [](const gpu::Hit& h) { return h.t < 0; }), 0);
}

// lavapipe stops all loops of a subgroup, silently, after 65 535 iterations. Rays along a soup of large overlapping triangles, aimed
// at gaps so that nothing ends them early, take thousands of iterations each, and four rays share an invocation.
TEST(Traversal, LoopCapIsNotMet) {
    Geometry g = generated::soup(100'000, 0.3f, 9);
    // Flattened to many thin layers: a ray between two layers passes the boxes of very many triangles and hits few.
    for (glm::vec3& p : g.positions)
        p.y *= 0.002f;
    Random random(9);
    std::vector<gpu::Ray> rays(20'000);
    for (gpu::Ray& r : rays) {
        r.origin = {-0.5f, random.between(-1e-3f, 3e-3f), random.uniform()};
        r.direction = glm::normalize(glm::vec3(1, random.between(-1e-4f, 1e-4f), random.between(-0.2f, 0.2f)));
    }
    compare(g, rays);
}

} // namespace
} // namespace cmpg

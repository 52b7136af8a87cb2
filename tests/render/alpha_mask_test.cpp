// Alpha masks: images and shadows against the coverage known on paper, rays against brute force.
#include "support/generated_geometry.h"
#include "support/render_fixture.h"
#include "support/scene_builder.h"
#include "support/tracer.h"

#include "render/scene_buffers.h"

#include <glm/gtc/constants.hpp>
#include <numeric>

namespace cmpg::test {
namespace {

using generated::Random;

// With materials that have holes.
struct Builder : SceneBuilder {
    Material& mask(std::uint32_t material, float cutoff, AlphaTexture texture) {
        Material& m = scene.materials[material];
        m.alphaMask = true;
        m.alphaCutoff = cutoff;
        m.alphaTexture = std::uint32_t(scene.alphaTextures.size());
        scene.alphaTextures.push_back(std::move(texture));
        return m;
    }
};

bool isHole(int column, int row) { return ((column ^ row) & 1) != 0; }

AlphaTexture checker(int cells) {
    AlphaTexture t;
    t.width = t.height = std::uint32_t(cells);
    t.nearest = true;
    for (int i = 0; i < cells * cells; ++i)
        t.alpha.push_back(isHole(i % cells, i / cells) ? 0 : 255);
    return t;
}

constexpr int kSize = 64, kCells = 8; // pixels, cells of the checker on an edge

// Pixels whose value is not lit where `visible(column of cells, row of cells from below)`, else 0. A sample or two on an edge
// between pixels may fall on its other side by rounding.
template <class Visible> void expectCells(const Image& image, float lit, const Visible& visible) {
    int wrong = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const float expected = visible(x * kCells / kSize, (kSize - 1 - y) * kCells / kSize) ? lit : 0.0f;
            wrong += std::abs(image.values[3 * (std::size_t(y) * kSize + std::size_t(x))] - expected) > 1e-4f * lit;
        }
    EXPECT_LE(wrong, 2);
}

TEST(AlphaMask, EmitterShowsThroughTheHoles) {
    Builder b;
    const std::uint32_t lamp = b.material("lamp", 0, 3), sheet = b.material("sheet", 0, 0);
    b.mask(sheet, 0.5f, checker(kCells));
    b.square(lamp, -1);
    b.square(sheet, 0);
    b.camera(1);
    Bench s(b.scene, {});
    Layers layers;
    expectCells(s.renderer->render(viewOf(s.scene, kSize, kSize), 16, {1, 0, 0}, {}, nullptr, &layers), 3, isHole);
    // The first hit is the lamp through a hole, the sheet elsewhere.
    EXPECT_NEAR(meanOf(layers.depth), 1.5, 1e-3);
}

// Slanted light moves the shadow by one cell; the camera is between sheet and floor.
TEST(AlphaMask, ShadowOfTheHoles) {
    Builder b;
    const std::uint32_t floor = b.material("floor", 0.5f, 0), sheet = b.material("sheet", 0, 0);
    b.mask(sheet, 0.5f, checker(kCells));
    b.square(floor, 0);
    b.square(sheet, 1);
    b.camera(0.5f);
    const glm::vec3 direction = glm::normalize(glm::vec3(0.25f, 0, -1));
    b.sun(direction);
    Bench s(b.scene, {});
    const float lit = 2 * 0.5f / glm::pi<float>() * -direction.z;
    // Left of the first cell the light comes in beside the sheet.
    expectCells(s.renderer->render(viewOf(s.scene, kSize, kSize), 16, {1, 0, 0}), lit,
                [](int column, int row) { return column == 0 || isHole(column - 1, row); });
}

// Alpha runs from 0 at u = 1/4 to 1 at u = 3/4; with factor 1/2 and vertex alpha 1/2 a cutoff of 0.075 keeps what lies beyond u = 0.4.
TEST(AlphaMask, CutoffFactorAndVertexColour) {
    Builder b;
    const std::uint32_t lamp = b.material("lamp", 0, 1), sheet = b.material("sheet", 0, 0);
    AlphaTexture ramp;
    ramp.width = 2;
    ramp.wrapU = Wrap::Clamp;
    ramp.alpha = {0, 255};
    b.mask(sheet, 0.075f, ramp).alphaFactor = 0.5f;
    b.square(lamp, -1);
    b.square(sheet, 0);
    b.scene.geometry.colors.assign(b.scene.geometry.positions.size(), glm::vec4(1, 1, 1, 0.5f));
    b.camera(1);
    Bench s(b.scene, {});
    const Image image = s.renderer->render(viewOf(s.scene, 10, 10), 64, {1, 0, 0});
    for (int i = 0; i < 100; ++i)
        EXPECT_NEAR(image.values[3 * std::size_t(i)], i % 10 < 4 ? 1 : 0, 0.02) << i; // one of 64 samples on the edge
}

// Extremes of the cutoff: 0 keeps everything, above 1 nothing is left.
TEST(AlphaMask, ExtremeCutoffs) {
    for (const auto& [cutoff, factor, transparent] : {std::tuple(0.0f, 1.0f, false), {1.5f, 1.0f, true}, {0.0f, 0.0f, false}, {0.1f, 0.0f, true}}) {
        Builder b;
        const std::uint32_t lamp = b.material("lamp", 0, 1), sheet = b.material("sheet", 0, 0);
        b.mask(sheet, cutoff, checker(2)).alphaFactor = factor;
        b.square(lamp, -1);
        b.square(sheet, 0);
        b.camera(1);
        Bench s(b.scene, {});
        EXPECT_EQ(meanOf(s.renderer->render(viewOf(s.scene, 4, 4), 4, {1, 0, 0})), transparent ? 1 : 0) << cutoff << " " << factor;
    }
}

// A lamp with holes, by drawing directions alone and with light sampling: a hole that emitted would double the light.
TEST(AlphaMask, HolesOfALampEmitNothing) {
    Builder b;
    const std::uint32_t lamp = b.material("lamp", 0, 5), floor = b.material("floor", 0.8f, 0);
    b.mask(lamp, 0.5f, checker(4));
    b.square(floor, 0);
    b.quad(lamp, {-1, 1, 1}, {2, 0, 0}, {0, -2, 0}); // faces down
    b.camera(0.5f);
    std::array<MeanError, 2> results;
    for (const bool lightSampling : {false, true}) {
        RenderConfig config;
        config.maxDepth = 2;
        config.lightSampling = lightSampling;
        Bench s(b.scene, {}, config);
        std::vector<double> means;
        for (std::uint32_t i = 0; i < 8; ++i)
            means.push_back(meanOf(s.renderer->render(viewOf(s.scene, 16, 16), 64, {i, 0, 0})));
        results[lightSampling] = statistics(means);
    }
    ASSERT_GT(results[0].mean, 0.1);
    EXPECT_NEAR(results[0].mean, results[1].mean, 4 * std::hypot(results[0].standardError, results[1].standardError));
}

// Partial coverage: alpha is the share of the light that a sheet stops, of whatever rays. Seeds are fixed; 4 standard errors.
struct Coverage : testing::Test {
    // Alpha 0, 64, 128, 255 in four columns, times a factor.
    static AlphaTexture columns() {
        AlphaTexture t;
        t.width = 4;
        t.nearest = true;
        t.alpha = {0, 64, 128, 255};
        return t;
    }
    static float alphaOf(int column) { return float(columns().alpha[std::size_t(column)]) / 255 * kFactor; }
    static void cover(Builder& b, std::uint32_t material) {
        Material& m = b.mask(material, 0.5f, columns());
        m.coverage = true;
        m.alphaFactor = kFactor;
    }
    // Means of columns of the image, over independent passes.
    static std::array<MeanError, 4> columnsOf(Bench& s, std::uint32_t spp) {
        std::array<std::vector<double>, 4> means;
        for (std::uint32_t i = 0; i < 8; ++i) {
            const Image image = s.renderer->render(viewOf(s.scene, 16, 16), spp, {i, 0, 0});
            for (int c = 0; c < 4; ++c) {
                double sum = 0;
                for (int y = 0; y < 16; ++y)
                    for (int x = 4 * c; x < 4 * c + 4; ++x)
                        sum += image.values[3 * (std::size_t(y) * 16 + std::size_t(x))];
                means[std::size_t(c)].push_back(sum / 64);
            }
        }
        return {statistics(means[0]), statistics(means[1]), statistics(means[2]), statistics(means[3])};
    }
    static void expectNear(const MeanError& found, double expected) {
        EXPECT_NEAR(found.mean, expected, 4 * found.standardError + 1e-6 * expected);
        EXPECT_LT(found.standardError, 0.02 * expected + 1e-9);
    }
    static constexpr float kFactor = 0.75f;
};

// Two sheets over a lamp, the upper one glowing: glTF's "over", twice.
TEST_F(Coverage, SheetsLieOverEachOther) {
    Builder b;
    const std::uint32_t lamp = b.material("lamp", 0, 3), sheet = b.material("sheet", 0, 0), glow = b.material("glow", 0, 1);
    cover(b, sheet);
    cover(b, glow);
    b.square(lamp, -1);
    b.square(sheet, 0);
    b.square(glow, 0.5f);
    b.camera(1);
    Bench s(b.scene, {});
    const auto found = columnsOf(s, 64);
    for (int c = 0; c < 4; ++c) {
        const double a = alphaOf(c);
        expectNear(found[std::size_t(c)], a + (1 - a) * (1 - a) * 3);
    }
}

// A point light, which only shadow rays find, above two sheets.
TEST_F(Coverage, ShadowsArePartial) {
    Builder b;
    const std::uint32_t floor = b.material("floor", 0.5f, 0), sheet = b.material("sheet", 0, 0);
    cover(b, sheet);
    b.square(floor, 0);
    b.square(sheet, 1);
    b.square(sheet, 1.5f);
    b.camera(0.5f);
    b.sun();
    Bench s(b.scene, {});
    const auto found = columnsOf(s, 64);
    for (int c = 0; c < 4; ++c)
        expectNear(found[std::size_t(c)], 2 * 0.5 / glm::pi<double>() * std::pow(1 - alphaOf(c), 2));
}

// A lamp of alpha a sends out a of its light, found by light sampling or not, and stops as much of what comes from a brighter one behind it.
TEST_F(Coverage, LampsEmitWhatTheyCover) {
    const auto image = [](bool covered, bool lightSampling, float nearEmission, float farEmission) {
        Builder b;
        const std::uint32_t lamp = b.material("lamp", 0, nearEmission), behind = b.material("behind", 0, farEmission), floor = b.material("floor", 0.8f, 0);
        if (covered) {
            AlphaTexture whole;
            whole.alpha = {102}; // 0.4
            b.mask(lamp, 0.5f, whole).coverage = true;
        }
        b.square(floor, 0);
        b.quad(lamp, {-1, 1, 1}, {2, 0, 0}, {0, -2, 0}); // face down
        b.quad(behind, {-1, 1, 1.25f}, {2, 0, 0}, {0, -2, 0});
        b.camera(0.5f);
        RenderConfig config;
        config.maxDepth = 2;
        config.lightSampling = lightSampling;
        Bench s(b.scene, {}, config);
        std::vector<double> means;
        for (std::uint32_t i = 0; i < 8; ++i)
            means.push_back(meanOf(s.renderer->render(viewOf(s.scene, 16, 16), 64, {i, 0, 0})));
        return statistics(means);
    };
    // Each alone, uncovered; the near one removed by a factor of its own light.
    const double nearAlone = image(false, true, 5, 0).mean;
    for (const bool lightSampling : {false, true}) {
        const MeanError nearCovered = image(true, lightSampling, 5, 0), both = image(true, lightSampling, 5, 20), farCovered = image(true, lightSampling, 0, 20);
        EXPECT_NEAR(nearCovered.mean, 0.4 * nearAlone, 4 * nearCovered.standardError + 2e-3 * nearAlone) << lightSampling;
        EXPECT_NEAR(both.mean, nearCovered.mean + farCovered.mean, 4 * std::hypot(both.standardError, nearCovered.standardError, farCovered.standardError)) << lightSampling;
        EXPECT_GT(farCovered.mean, 2 * nearCovered.mean) << lightSampling;
    }
}

// Reverse and forward derivatives of what stands behind and of the sheet itself: along the same rays as the image, so the sum is exact.
TEST_F(Coverage, DerivativesFollow) {
    Builder b;
    const std::uint32_t lamp = b.material("lamp", 0, 3), sheet = b.material("sheet", 0.5f, 0);
    cover(b, sheet);
    b.square(lamp, -1);
    b.square(sheet, 0);
    b.camera(1);
    b.sun();
    Bench s(b.scene, {"lamp.emission", "sheet.baseColor"});
    const View view = viewOf(s.scene, 16, 16);
    const double image = meanOf(s.renderer->render(view, 64, {1, 0, 1}, s.plan, &s.result));
    std::vector<std::vector<double>> gradients;
    s.result = s.renderer->reverse(view, 64, {1, 0, 1}, Image(16, 16, 3, 1.0f / (16 * 16 * 3)), {}, {}, gradients, s.plan);
    const double byLamp = std::accumulate(gradients[0].begin(), gradients[0].end(), 0.0), bySheet = std::accumulate(gradients[1].begin(), gradients[1].end(), 0.0);
    EXPECT_GT(byLamp, 0.3);
    EXPECT_NEAR(byLamp * 3 + bySheet * 0.5, image, 1e-5 * image); // linear in both
}

// What stands at a point of triangle t, in double precision; barycentrics as weights of the second and third vertex.
struct Meeting {
    double t = -1;
    std::uint32_t triangle = ~0u;
    bool nearEdge = false; // of a triangle or a texel: rounding decides
};

Meeting bruteForce(const Scene& scene, const gpu::Ray& ray) {
    Meeting nearest;
    bool nearEdge = false;
    for (std::uint32_t i = 0; i < scene.geometry.triangles.size(); ++i) {
        const Triangle& triangle = scene.geometry.triangles[i];
        const glm::dvec3 o = ray.origin, d = ray.direction, a = scene.geometry.positions[triangle.vertices[0]];
        const glm::dvec3 e1 = glm::dvec3(scene.geometry.positions[triangle.vertices[1]]) - a;
        const glm::dvec3 e2 = glm::dvec3(scene.geometry.positions[triangle.vertices[2]]) - a;
        const glm::dvec3 w = glm::inverse(glm::dmat3(-d, e1, e2)) * (o - a); // t, weights
        const double inside = std::min({w.y, w.z, 1 - w.y - w.z});
        nearEdge |= std::abs(inside) < 1e-5;
        if (inside < 0 || w.x <= 0 || (nearest.t >= 0 && w.x >= nearest.t))
            continue;
        const auto uv = [&](int k) { return glm::dvec2(scene.geometry.uv0[triangle.vertices[std::size_t(k)]]); };
        const glm::dvec2 at = (1 - w.y - w.z) * uv(0) + w.y * uv(1) + w.z * uv(2);
        const Material& m = scene.materials[triangle.material];
        if (m.alphaMask) {
            const AlphaTexture& texture = scene.alphaTextures[m.alphaTexture];
            const glm::dvec2 texel = at * glm::dvec2(texture.width, texture.height), fraction = texel - glm::floor(texel);
            const double margin = std::min({fraction.x, fraction.y, 1 - fraction.x, 1 - fraction.y});
            nearEdge |= margin < 1e-4;
            if (isHole(int(texel.x), int(texel.y)))
                continue;
        }
        nearest.t = w.x;
        nearest.triangle = i;
    }
    nearest.nearEdge = nearEdge;
    return nearest;
}

void compareRays(bool portable) {
    Device device(Device::Options{.select = {}, .validation = false, .portable = portable});
    Builder b;
    Random random(4);
    const std::uint32_t solid = b.material("solid", 0.5f, 0), sheet = b.material("sheet", 0.5f, 0);
    b.mask(sheet, 0.5f, checker(kCells));
    for (int i = 0; i < 60; ++i) {
        const glm::vec3 u = random.direction() * random.between(0.3f, 1.5f);
        const glm::vec3 v = glm::normalize(glm::cross(u, random.direction())) * random.between(0.3f, 1.5f);
        b.quad(i % 6 ? sheet : solid, random.inBox(glm::vec3(-1), glm::vec3(1)), u, v);
    }
    const FeatureSet features = analyse(b.scene, {.lightSampling = false});
    ASSERT_TRUE(features.alphaMask);
    const SceneBuffers buffers(device, b.scene, features, {}, false);
    const Bvh bvh = buildBvh(b.scene.geometry);
    Bindings bindings;
    buffers.bind(bindings);
    Tracer tracer(device, bvh, bvh.depth, features, bindings);

    std::vector<gpu::Ray> rays(20'000);
    for (gpu::Ray& r : rays)
        r = {random.inBox(glm::vec3(-2), glm::vec3(2)), 0, random.direction(), 0};
    const auto hits = tracer.closest(rays);
    std::vector<gpu::ShadowRay> shadowRays;
    std::size_t met = 0, wrong = 0, undecided = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Meeting expected = bruteForce(b.scene, rays[i]);
        const gpu::Hit& hit = hits[i];
        met += expected.t >= 0;
        const bool same = expected.t < 0 ? hit.t < 0 : hit.t >= 0 && bvh.order.at(hit.triangle) == expected.triangle && std::abs(hit.t - expected.t) < 1e-4 * expected.t;
        undecided += expected.nearEdge;
        wrong += !same && !expected.nearEdge;
        const float factors[] = {0.999f, 1.001f, 10.f, 0.5f};
        shadowRays.push_back({rays[i].origin, hit.t >= 0 ? hit.t * factors[i % 4] : float(i % 7), rays[i].direction, std::uint32_t(i)});
    }
    EXPECT_GT(met, rays.size() / 4);
    EXPECT_EQ(wrong, 0u);
    EXPECT_LT(undecided, rays.size() / 20);
    const auto visible = tracer.visible(shadowRays);
    std::size_t contradictions = 0;
    for (std::size_t i = 0; i < rays.size(); ++i)
        contradictions += visible[i] != (hits[i].t >= 0 && hits[i].t < shadowRays[i].distance ? 0u : 1u);
    EXPECT_EQ(contradictions, 0u) << "shadow rays that contradict the nearest hit";
}

TEST(AlphaMask, RaysAgreeWithBruteForce) { compareRays(false); }
TEST(AlphaMask, RaysAgreeWithBruteForcePortable) { compareRays(true); }

} // namespace
} // namespace cmpg::test

// Dielectrics, panes, conductors and plastics in whole images: energy, closed forms, derivatives, guiding.
#include "base/error.h"
#include "support/derivative_fixture.h"
#include "support/guided_fixture.h"
#include "support/material_json.h"
#include "support/scene_builder.h"

#include <algorithm>
#include <fstream>

namespace cmpg::test {
namespace {

// A scene put together by hand whose materials may be boundaries.
struct Builder : SceneBuilder {
    std::uint32_t boundary(const std::string& name, SurfaceModel model, float ior) {
        const std::uint32_t at = material(name, 1, 0);
        Material& m = scene.materials[at];
        m.model = model;
        m.ior = ior;
        m.smooth = true;
        setConstant(scene, m, SlotKind::Specular, {1, 1, 1});
        return at;
    }
    void sky(float radiance) {
        Parameter p;
        p.name = "environment.radiance";
        p.kind = SlotKind::Radiance;
        p.width = 4;
        p.height = 2;
        p.values.assign(p.entries(), radiance);
        scene.environment = {std::uint32_t(scene.parameters.size()), 0};
        scene.parameters.push_back(p);
    }
    // Interpolated normals.
    void sphere(std::uint32_t material, glm::vec3 center, float radius, std::uint32_t columns) {
        Geometry& g = scene.geometry;
        const auto base = std::uint32_t(g.positions.size()), rows = columns / 2;
        g.normals.resize(g.positions.size(), glm::vec3(0));
        for (std::uint32_t j = 0; j <= rows; ++j)
            for (std::uint32_t i = 0; i <= columns; ++i) {
                const float theta = 3.14159265f * float(j) / float(rows), phi = 6.2831853f * float(i % columns) / float(columns);
                const glm::vec3 n(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
                g.positions.push_back(center + radius * n);
                g.normals.push_back(n);
                g.uv0.emplace_back(float(i) / float(columns), float(j) / float(rows));
            }
        const auto at = [&](std::uint32_t j, std::uint32_t i) { return base + j * (columns + 1) + i; };
        for (std::uint32_t j = 0; j < rows; ++j)
            for (std::uint32_t i = 0; i < columns; ++i) {
                if (j > 0)
                    g.triangles.push_back({{at(j, i), at(j + 1, i), at(j, i + 1)}, material});
                if (j + 1 < rows)
                    g.triangles.push_back({{at(j, i + 1), at(j + 1, i), at(j + 1, i + 1)}, material});
            }
    }
};

double fresnel(double c, double eta) {
    const double t = std::sqrt(1 - (1 - c * c) / (eta * eta)), s = (c - eta * t) / (c + eta * t), p = (eta * c - t) / (eta * c + t);
    return 0.5 * (s * s + p * p);
}

// Under a sky of 1 clear glass is invisible: nothing is lost at any boundary, and the scales of radiance cancel. Faceted, and with interpolated normals:
// those of coarser meshes let light in near the silhouette that total reflection never lets out.
TEST(Glass, BallInAWhiteFurnaceIsInvisible) {
    for (const std::uint32_t columns : {12u, 256u})
        for (const float ior : {1.5f, 0.75f}) {
            Builder b;
            b.sphere(b.boundary("glass", SurfaceModel::Dielectric, ior), {0, 0, 0}, 0.8f, columns);
            b.sphere(b.boundary("core", SurfaceModel::Dielectric, 1.0f / ior), {0.1f, 0, 0}, 0.4f, columns); // a bubble
            if (columns == 12)
                b.scene.geometry.normals.clear();
            b.sky(1);
            b.camera(2);
            RenderConfig config;
            config.maxDepth = 300;
            Bench s(b.scene, {}, config);
            const Image image = s.renderer->render(viewOf(s.scene, 32, 32), 64, {1, 0, 0});
            EXPECT_NEAR(meanOf(image), 1, 1e-4) << columns << " columns, index " << ior;
        }
}

// Microfacets of a coarse ball's interpolated normals reflect light into the faces, and refract it out of them again: radiance is scaled where a path crosses
// a face, so none brings more than the sky has, and no more is lost than by the faces' own normals, whose microfacets mask each other. Scaled by the normals'
// sides, single paths brought 2.6.
TEST(Glass, NoPathThroughARoughBallBringsMoreThanTheSky) {
    const auto ball = [](float alpha, bool faceted) {
        Builder b;
        const std::uint32_t glass = b.boundary("frosted", SurfaceModel::Dielectric, 1.5f);
        b.scene.materials[glass].smooth = false;
        setConstant(b.scene, b.scene.materials[glass], SlotKind::Roughness, {alpha});
        b.sphere(glass, {0, 0, 0}, 0.9f, 10);
        if (faceted)
            b.scene.geometry.normals.clear();
        b.sky(1);
        b.camera(2);
        RenderConfig config;
        config.maxDepth = 100;
        config.lightSampling = false; // a path has the weight of its directions alone
        Bench s(b.scene, {}, config);
        return s.renderer->render(viewOf(s.scene, 128, 128), 1, {1, 0, 0});
    };
    for (const float alpha : {0.1f, 0.3f}) {
        const Image image = ball(alpha, false);
        EXPECT_LE(*std::max_element(image.values.begin(), image.values.end()), 1.001f) << alpha;
        EXPECT_NEAR(meanOf(image), meanOf(ball(alpha, true)), 0.03) << alpha;
    }
}

// A lamp of radiance 2 behind, a sky of 1 before.
double lampBehind(Builder& b, std::uint32_t spp) {
    b.quad(b.material("lamp", 0, 2), {-20, -20, -5}, {40, 0, 0}, {0, 40, 0});
    b.sky(1);
    RenderConfig config;
    config.maxDepth = 64;
    Bench s(b.scene, {}, config);
    std::vector<double> means;
    for (std::uint32_t i = 0; i < 8; ++i)
        means.push_back(meanOf(s.renderer->render(viewOf(s.scene, 8, 8), spp, {i, 0, 0})));
    const MeanError found = statistics(means);
    EXPECT_LT(found.standardError, 2e-3);
    return found.mean;
}

TEST(Glass, PaneLetsThroughWhatItDoesNotReflect) {
    Builder b;
    b.square(b.boundary("pane", SurfaceModel::ThinDielectric, 1.5f), 0);
    b.camera(2);
    const double r = fresnel(1, 1.5), reflected = 2 * r / (1 + r);
    EXPECT_NEAR(lampBehind(b, 512), 2 - reflected, 5e-3);
}

// Both faces of a slab come to the same as a pane: with the reflections between them, and radiance as it was.
TEST(Glass, SlabIsAPane) {
    Builder b;
    const std::uint32_t glass = b.boundary("glass", SurfaceModel::Dielectric, 1.5f);
    b.quad(glass, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0});
    b.quad(glass, {-20, -20, -0.5f}, {0, 40, 0}, {40, 0, 0}); // looks down
    b.camera(2);
    const double r = fresnel(1, 1.5), reflected = 2 * r / (1 + r);
    EXPECT_NEAR(lampBehind(b, 512), 2 - reflected, 5e-3);
}

// Beer and Lambert's law on every passage between the faces, in each channel.
TEST(Glass, SlabAbsorbs) {
    Builder b;
    const std::uint32_t glass = b.boundary("glass", SurfaceModel::Dielectric, 1.5f);
    b.scene.materials[glass].absorption = {0, 0.7f, 3};
    b.quad(glass, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0});
    b.quad(glass, {-20, -20, -0.5f}, {0, 40, 0}, {40, 0, 0}); // looks down
    b.camera(2);
    const double r = fresnel(1, 1.5);
    double expected = 0;
    for (const double absorption : {0.0, 0.7, 3.0}) {
        const double kept = std::exp(-0.5 * absorption), passed = (1 - r) * (1 - r) * kept / (1 - r * r * kept * kept);
        expected += (r + passed * r * kept + 2 * passed) / 3;
    }
    EXPECT_NEAR(lampBehind(b, 512), expected, 5e-3);
}

// The mean of images of few pixels, with light sampling or without.
MeanError meanByLightSampling(const Scene& scene, RenderConfig config, bool sampled) {
    config.lightSampling = sampled;
    Bench s(scene, {}, config);
    std::vector<double> values;
    for (std::uint32_t i = 0; i < 12; ++i)
        values.push_back(meanOf(s.renderer->render(viewOf(s.scene, 24, 24), 64, {100 * sampled + i, 0, 0})));
    const MeanError mean = statistics(values);
    EXPECT_LT(mean.standardError, 0.02 * mean.mean);
    return mean;
}

// A matt ball of ink: what comes out of a rough boundary, with light samples and without.
TEST(Glass, LightSamplingChangesNoExpectationOfInk) {
    MeanError means[2];
    for (const bool sampled : {false, true}) {
        Builder b;
        const std::uint32_t ink = b.boundary("ink", SurfaceModel::Dielectric, 1.3f);
        b.scene.materials[ink].smooth = false;
        b.scene.materials[ink].absorption = {0.2f, 0.7f, 3};
        setConstant(b.scene, b.scene.materials[ink], SlotKind::Roughness, {0.4f});
        b.sphere(ink, {0, 0, 0}, 0.8f, 64);
        b.sky(0.5f);
        b.quad(b.material("lamp", 0, 4), {-1, 1, 1.5f}, {2, 0, 0}, {0, -2, 0}); // looks down
        b.camera(1.2f);
        RenderConfig config;
        config.maxDepth = 12;
        means[sampled] = meanByLightSampling(b.scene, config, sampled);
    }
    expectAgreement(means[0], means[1], "with light sampling");
}

// One boundary: radiance shrinks by the squared index on its way out.
TEST(Glass, RadianceIsScaledBetweenMedia) {
    Builder b;
    b.quad(b.boundary("glass", SurfaceModel::Dielectric, 1.5f), {-20, -20, 0}, {40, 0, 0}, {0, 40, 0});
    b.camera(2);
    const double r = fresnel(1, 1.5);
    EXPECT_NEAR(lampBehind(b, 512), r + (1 - r) * 2 / (1.5 * 1.5), 5e-3);
}

// Beyond the critical angle all is reflected: a slanted prism face seen from within.
TEST(Glass, TotalReflection) {
    Builder b;
    const std::uint32_t glass = b.boundary("glass", SurfaceModel::Dielectric, 1 / 1.5f); // the camera's side is inside
    b.quad(glass, {-20, -20, -20}, {40, 0, 40}, {0, 40, 0});                            // 45 degrees
    b.camera(2);
    // It looks down and sees the sky at the side; the lamp below is hidden.
    EXPECT_NEAR(lampBehind(b, 64), 1, 1e-5);
}

// Emission found through glass counts fully, light samples at glass count nothing: with and without them the same.
TEST(Glass, LightSamplingChangesNoExpectation) {
    MeanError means[2];
    for (const bool sampled : {false, true})
        means[sampled] = meanByLightSampling(bundledScene("glass"), {}, sampled);
    expectAgreement(means[0], means[1], "with light sampling");
}

nlohmann::json variants() {
    std::ifstream file(std::string(CMPG_SOURCE_DIR) + "/tests/reference/references.json");
    const nlohmann::json all = nlohmann::json::parse(file)["references"];
    return {{"metals", all["metals_image"]["materials"]}, {"coats", all["coats_image"]["materials"]}, {"inked", all["coats_image"]["materials"]}, {"glass", nlohmann::json::object()}};
}

// Bundled scenes, with materials of Mitsuba's in place of some.
Scene variant(const std::string& name) {
    Scene scene = bundledScene(name == "glass" ? "glass" : "materials");
    const nlohmann::json all = variants();
    for (const auto& [material, json] : all[name].items())
        replaceMaterial(scene, material, json);
    for (Material& m : scene.materials)
        if (name == "inked" && m.model == SurfaceModel::Dielectric)
            m.absorption = {0.5f, 2, 4};
    for (Parameter& p : scene.parameters)
        p.materialise();
    return scene;
}

struct Case {
    const char *scene, *parameters;
};
class Boundary : public testing::TestWithParam<Case> {};

// With all features, so that kernels are compiled once for all cases; those of each scene's own features are compared with Mitsuba's derivatives.
TEST_P(Boundary, ForwardAgreesWithReverse) {
    expectForwardAgreesWithReverse(Bench(variant(GetParam().scene), {GetParam().parameters}, {.allFeatures = true}));
}

// Directions, lights and densities stay; only f is evaluated with the perturbed values.
TEST_P(Boundary, FrozenFiniteDifferences) {
    RenderConfig config;
    config.frozenEvaluation = true;
    config.maxDepth = 6;
    Bench s(variant(GetParam().scene), {GetParam().parameters}, config);
    const View view = viewOf(s.scene, 24, 24);
    const PassKey key{7, 0, 1};
    const auto directions = randomDirections(s, 3);
    const Image forward = s.renderer->forward(view, 16, key, s.config.differentiable, directions);
    const float h = 2e-3f;
    const auto shifted = [&](float step) { return frozenImage(s, view, key, directions, step); };
    const Image plus = shifted(h), minus = shifted(-h), plus2 = shifted(2 * h), minus2 = shifted(-2 * h);
    double difference = 0, norm = 0;
    std::size_t unusable = 0;
    for (std::size_t i = 0; i < forward.values.size(); ++i) {
        const double narrow = (double(plus.values[i]) - minus.values[i]) / (2 * h), wide = (double(plus2.values[i]) - minus2.values[i]) / (4 * h);
        const double expected = (4 * narrow - wide) / 3;
        const double tolerance = 1e-3 * std::abs(expected) + 4e-6 * (std::abs(plus.values[i]) + 1e-3) / h;
        if (std::abs(narrow - wide) > 0.01 * std::abs(expected) + tolerance) { // a corner of a table, a jump
            ++unusable;
            continue;
        }
        difference += (forward.values[i] - expected) * (forward.values[i] - expected);
        norm += expected * expected;
    }
    ASSERT_GT(norm, 0);
    EXPECT_LT(std::sqrt(difference / norm), 2e-3);
    EXPECT_LE(unusable, forward.values.size() / 20) << "pixels without a usable difference";
}

INSTANTIATE_TEST_SUITE_P(Slots, Boundary,
                         testing::Values(Case{"glass", "*.baseColor"}, Case{"glass", "b*.specular"}, Case{"metals", "brass.*o*"}, Case{"metals", "half.baseColor"},
                                         Case{"metals", "plastic.*o*"}, Case{"metals", "plastic.specular"}, Case{"coats", "*.baseColor"},
                                         Case{"coats", "half.specular"}, Case{"coats", "half.roughness"}, Case{"coats", "brass.roughness"}, Case{"inked", "*.baseColor"}, Case{"inked", "brass.roughness"}),
                         [](const auto& test) {
                             std::string name = std::string(test.param.scene) + "_" + test.param.parameters + std::to_string(test.index);
                             std::replace_if(name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)) && c != '_'; }, '_');
                             return name;
                         });

// An image and how it differs along the same paths, in one pass.
TEST(Glass, DifferencesAreThoseOfImages) {
    RenderConfig config;
    config.differences = true;
    RenderConfig frozen;
    frozen.frozenEvaluation = true;
    Bench both(variant("glass"), {"b*.baseColor"}, config), second(variant("glass"), {"b*.baseColor"}, frozen);
    const View view = viewOf(both.scene, 24, 24);
    const PassKey key{7, 0, 1};
    for (const std::uint32_t p : both.config.differentiable) {
        std::vector<float> values = both.scene.parameters[p].values;
        for (float& v : values)
            v *= 0.9f;
        both.renderer->setSecondValues(p, values);
        second.renderer->setSecondValues(p, values);
    }
    const ImageDifference found = both.renderer->renderDifference(view, 16, key);
    const Image other = second.renderer->render(view, 16, key);
    expectDifference(found, other);
}

// The guide learns and draws around glass without changing what comes out.
TEST(Glass, GuidingChangesNoExpectation) {
    GuidedBench s("glass", {"painting.baseColor"}, 24, guidedConfig(8));
    const auto gradient = [&](std::uint64_t seed) { return s.along(s.gradient(32, {seed, 0, 1}), 0); };
    const auto image = [&](std::uint64_t seed) { return meanOf(s.renderer->render(s.view, 32, {seed, 0, 0}, s.plan)); };
    const auto estimate = [&](const auto& what, std::uint64_t first) {
        std::vector<double> values;
        for (std::uint64_t i = 0; i < 12; ++i)
            values.push_back(what(first + i));
        return statistics(values);
    };
    const MeanError plainImage = estimate(image, 1), plainGradient = estimate(gradient, 50);
    const double reference = s.train(4, 32);
    s.plan = {.method = {.kind = Sampling::Primal}};
    const MeanError guidedImage = estimate(image, 100);
    expectAgreement(guidedImage, plainImage, "image");
    s.plan = {.method = {.kind = Sampling::Conditional, .roulette = true}, .reference = reference};
    const MeanError guidedGradient = estimate(gradient, 200);
    expectAgreement(guidedGradient, plainGradient, "gradient");
    std::cout << "variance by guiding: image " << std::pow(guidedImage.standardError / plainImage.standardError, 2) << ", gradient "
              << std::pow(guidedGradient.standardError / plainGradient.standardError, 2) << "\n";
}

TEST(Boundaries, NormalsOfWhatTheyTurnAreRefused) {
    EXPECT_THROW(Bench(variant("glass"), {"ball.normal"}), Error);
    EXPECT_THROW(Bench(variant("coats"), {"brass.normal"}), Error);
    EXPECT_NO_THROW(Bench(variant("metals"), {"plastic.normal"}));
}

} // namespace
} // namespace cmpg::test

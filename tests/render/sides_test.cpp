// Surfaces reflect on both sides: which way the corners of what emits nothing run changes neither images nor derivatives. Seeds are fixed.
#include "support/render_fixture.h"
#include "support/scene_builder.h"

#include <numeric>
#include <utility>

namespace cmpg::test {
namespace {

constexpr int kEdge = 16;
constexpr std::uint32_t kSpp = 64;

struct Lighting {
    const char* name;
    bool panel = false, sky = false;
    std::vector<PunctualLight> lights = {};
};

PunctualLight light(PunctualLight::Kind kind, glm::vec3 position) {
    PunctualLight l;
    l.kind = kind;
    l.position = position;
    l.direction = glm::normalize(glm::vec3(0.2f, -0.1f, -1));
    l.innerCos = 0.95f;
    return l;
}

const PunctualLight kPoint = light(PunctualLight::Kind::Point, {0.5f, 0.3f, 1.2f}), kOther = light(PunctualLight::Kind::Point, {-0.6f, -0.2f, 0.8f}),
                    kSpot = light(PunctualLight::Kind::Spot, {-0.3f, 0.1f, 1.5f}), kSun = light(PunctualLight::Kind::Directional, {});

// A floor and a wall, purely diffuse, and a panel that looks down.
Scene corner(const Lighting& lighting, bool reversed) {
    SceneBuilder b;
    const std::uint32_t matt = b.material("matt", 0.6f, 0), lamp = b.material("lamp", 0.2f, 5);
    b.scene.parameters[b.scene.materials[matt].parameters[std::size_t(SlotKind::Specular)]].values = {0};
    b.square(matt, 0);
    b.quad(matt, {-1, -1, 0}, {0, 2, 0}, {0, 0, 1});
    if (reversed)
        for (Triangle& t : b.scene.geometry.triangles)
            std::swap(t.vertices[1], t.vertices[2]);
    if (lighting.panel)
        b.quad(lamp, {0.6f, -0.2f, 1.5f}, {-0.8f, 0, 0.1f}, {0, 0.8f, 0}); // its front looks along u x v: down
    if (lighting.sky) {
        Parameter p;
        p.name = "environment.radiance";
        p.kind = SlotKind::Radiance;
        p.width = 8;
        p.height = 5;
        for (std::uint32_t i = 0; i < p.entries(); ++i)
            p.values.push_back(0.1f + 0.05f * float(i % 11));
        b.scene.environment = Environment{std::uint32_t(b.scene.parameters.size()), 0};
        b.scene.parameters.push_back(p);
    }
    b.scene.lights = lighting.lights;
    b.camera(3);
    return b.scene;
}

struct Outputs {
    double image, forward, reverse;
};

class Sides : public testing::TestWithParam<Lighting> {
  protected:
    static Outputs outputs(bool reversed, bool guided, bool lightSampling = true, std::uint32_t spp = kSpp) {
        RenderConfig config;
        config.maxDepth = 3;
        config.guiding = guided;
        config.lightSampling = lightSampling;
        config.guide.cellRecords = 400;
        Bench b(corner(GetParam(), reversed), {"matt.baseColor"}, config);
        const View view = viewOf(b.scene, kEdge, kEdge);
        const Image adjoint(kEdge, kEdge, 3, 1);
        std::vector<std::vector<double>> gradients;
        for (std::uint32_t i = 0; guided && i < 2; ++i) {
            b.plan = {.record = true};
            b.result = b.renderer->reverse(view, kSpp, {7, i, 3}, adjoint, {}, {}, gradients, b.plan);
            b.renderer->updateGuide();
        }
        if (guided)
            b.plan = {.method = {Sampling::Conditional}};
        const double image = meanOf(b.renderer->render(view, spp, {1, 0, 0}, b.plan, &b.result));
        const double forward = meanOf(b.renderer->forward(view, spp, {1, 0, 1}, b.config.differentiable, b.ones(), b.plan, &b.result));
        gradients.clear();
        b.result = b.renderer->reverse(view, spp, {1, 0, 1}, adjoint, {}, {}, gradients, b.plan);
        return {image, forward, std::accumulate(gradients[0].begin(), gradients[0].end(), 0.0) / double(adjoint.values.size())};
    }

    // Equal random numbers: what differs is rounding, or, `share`, noise.
    static void expectEqual(const Outputs& a, const Outputs& b, double share, const char* what) {
        EXPECT_GT(a.image, 0.01) << what; // what is compared is there
        EXPECT_GT(a.forward, 0.01) << what;
        EXPECT_NEAR(a.image, b.image, share * a.image) << what;
        EXPECT_NEAR(a.forward, b.forward, share * a.forward) << what;
        EXPECT_NEAR(a.reverse, b.reverse, share * a.forward) << what;
    }
};

TEST_P(Sides, CornersRunEitherWay) {
    const Outputs front = outputs(false, false);
    expectEqual(front, outputs(true, false), 1e-4, "unguided");
    if (GetParam().lights.empty()) // lamps without extent are found by light sampling alone
        expectEqual(front, outputs(true, false, false, 16 * kSpp), 0.03, "without light sampling"); // noise of about 1 %
}

class GuidedSides : public Sides {};

TEST_P(GuidedSides, CornersRunEitherWay) {
    const Outputs front = outputs(false, true);
    expectEqual(front, outputs(true, true), 2e-3, "guided"); // one path that rounding sends elsewhere teaches the guide something else
}

// Of one side the front is as ever, bit for bit, and nothing comes from behind: whichever way light finds the surface.
TEST_P(Sides, OneSidedSurfacesAreBlackFromBehind) {
    const auto image = [](bool reversed, bool oneSided) {
        Scene scene = corner(GetParam(), reversed);
        scene.materials[0].oneSided = oneSided;
        scene.materials[1].oneSided = oneSided && reversed; // else the panel's back is lit
        RenderConfig config;
        config.maxDepth = 3;
        Bench b(std::move(scene), {}, config);
        return b.renderer->render(viewOf(b.scene, kEdge, kEdge), kSpp, {1, 0, 0});
    };
    EXPECT_EQ(image(false, true).values, image(false, false).values);
    // The sky and the panel's own light are seen directly, and do not depend on the surfaces.
    RenderConfig direct;
    direct.maxDepth = 1;
    Bench emitters(corner(GetParam(), true), {}, direct);
    const Image seen = emitters.renderer->render(viewOf(emitters.scene, kEdge, kEdge), kSpp, {1, 0, 0});
    EXPECT_EQ(image(true, true).values, seen.values);
}

std::string lightingName(const testing::TestParamInfo<Lighting>& lighting) { return lighting.param.name; }

const Lighting kAll{"All", true, true, {kPoint, kSpot, kSun}};
const auto kSingle = testing::Values(Lighting{"Panel", true}, Lighting{"Sky", false, true}, Lighting{"Points", false, false, {kPoint, kOther}},
                                     Lighting{"Spots", false, false, {kSpot, kSpot}}, Lighting{"Suns", false, false, {kSun, kSun}},
                                     Lighting{"OnePoint", false, false, {kPoint}});

INSTANTIATE_TEST_SUITE_P(Lights, Sides, kSingle, lightingName);
INSTANTIATE_TEST_SUITE_P(AllLights, Sides, testing::Values(kAll), lightingName);
INSTANTIATE_TEST_SUITE_P(AllLights, GuidedSides, testing::Values(kAll), lightingName); // a guide does not know which light it learned from; one kind each: long tests
INSTANTIATE_TEST_SUITE_P(FullLights, GuidedSides, kSingle, lightingName);

} // namespace
} // namespace cmpg::test

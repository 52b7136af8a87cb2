// Whole images against values known on paper: a sun of 1e6 : 1, lights that graze a plane or lie in it, depth, textures of all sizes,
// very many samples.
#include "support/guided_fixture.h"
#include "support/scene_builder.h"
#include "worst.h"

#include <glm/gtc/matrix_transform.hpp>

namespace cmpg::test {
namespace {

// Looks down at the square [-1,1]^2 at height 0, y being up; camera coordinates run over `half` to each side of `at`.
Camera above(glm::vec3 at, float half, float height) {
    Camera camera;
    camera.orthographic = true;
    camera.ymag = half;
    camera.toWorld = glm::translate(glm::mat4(1), at + glm::vec3(0, height, 0)) * glm::rotate(glm::mat4(1), -glm::half_pi<float>(), glm::vec3(1, 0, 0));
    return camera;
}

void addFloor(SceneBuilder& b, std::uint32_t material) { b.quad(material, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}); }

Parameter& valueOf(Scene& scene, std::uint32_t material, SlotKind kind) { return scene.parameters[scene.materials[material].parameters[std::size_t(kind)]]; }

MeanError meanOver(Bench& s, const View& view, std::uint32_t spp, std::uint32_t seeds) {
    std::vector<double> means;
    for (std::uint32_t i = 0; i < seeds; ++i) means.push_back(meanOf(s.renderer->render(view, spp, {100 + i, 0, 0}, s.plan, &s.result)));
    return statistics(means);
}

std::uint64_t dropped(const Bench& s) {
    std::uint64_t sum = 0;
    for (const auto& [kind, count] : s.renderer->statistics().dropped) sum += count;
    return sum;
}

// A white sky with a sun in two texels over a grey plane; without a guide, and with one that learned nothing but the sun.
TEST(ExtremeTransport, SunInTwoTexels) {
    Bias bias("image | plane under a sun of 1e6 : 1 in two texels | map 8 x 4, 64 x 32; guided and not", "quadrature in float64");
    for (const std::uint32_t height : {4u, 32u}) {
        SceneBuilder b;
        const float albedo = 0.5f;
        addFloor(b, b.material("floor", albedo, 0));
        Parameter sky;
        sky.name = "environment.radiance";
        sky.kind = SlotKind::Radiance;
        sky.width = 2 * height;
        sky.height = height;
        sky.textured = true;
        sky.values.assign(sky.entries(), 1.0f);
        const std::uint32_t row = height / 4, column = height / 2 + 1;
        for (std::uint32_t i = 0; i < 6; ++i) sky.values[(row * sky.width + column) * 3 + i] = 1e6f;
        b.scene.environment = Environment{std::uint32_t(b.scene.parameters.size())};
        b.scene.parameters.push_back(sky);
        b.scene.cameras = {above({}, 0.5f, 1)};

        const int steps = 64 * 32 / int(height);
        double truth = 0;
        for (std::uint32_t j = 0; 2 * j < sky.height - 1; ++j)
            for (std::uint32_t i = 0; i < sky.width; ++i) {
                const auto texel = [&](std::uint32_t x, std::uint32_t y) { return double(sky.values[(y * sky.width + x % sky.width) * 3]); };
                for (int k = 0; k < steps; ++k) {
                    const double y = (k + 0.5) / steps, theta = glm::pi<double>() * (j + y) / (sky.height - 1.0);
                    if (theta >= glm::half_pi<double>()) continue;
                    // Linear along the row, so its middle is its mean.
                    const double radiance = 0.5 * ((texel(i, j) + texel(i + 1, j)) * (1 - y) + (texel(i, j + 1) + texel(i + 1, j + 1)) * y);
                    truth += radiance * std::cos(theta) * std::sin(theta) * glm::pi<double>() / (sky.height - 1.0) / steps * glm::two_pi<double>() / sky.width;
                }
            }
        truth *= double(albedo) / glm::pi<double>();

        Bench s(b.scene, {"floor.baseColor"}, guidedConfig(2));
        const View view = viewOf(s.scene, 8, 8);
        const MeanError plain = meanOver(s, view, 256, 16);
        bias.add(plain.mean, plain.standardError, truth, 1e-5 * truth, [&] { return "rows " + std::to_string(height) + ": " + std::to_string(plain.mean) + " truth " + std::to_string(truth); });
        std::vector<std::vector<double>> ignored;
        for (std::uint32_t i = 0; i < 3; ++i) {
            s.plan = {.record = true};
            s.result = s.renderer->reverse(view, 32, {7, i, 3}, Image(8, 8, 3, 1.0f), {}, {}, ignored, s.plan);
            s.renderer->updateGuide();
        }
        s.plan = {.method = {Sampling::Conditional}};
        const MeanError guided = meanOver(s, view, 256, 16);
        bias.add(guided.mean, guided.standardError, truth, 1e-5 * truth, [&] { return "guided, rows " + std::to_string(height) + ": " + std::to_string(guided.mean) + " truth " + std::to_string(truth); });
        EXPECT_EQ(dropped(s), 0u);
    }
}

// A lamp that looks down from ever closer to the floor's plane, beside the patch the camera sees. Positions are rounded to 6e-8, which
// turns such flat directions: their cosines, 1e-1 to 1e-4, are no better than 1e-7 over themselves, and two of them multiply.
TEST(ExtremeTransport, LampGrazingTheFloor) {
    Bias bias("image | floor lit by a lamp at grazing angles | 6 to 0.006 degrees; allowed beside: 2e-7 over the angle", "quadrature in float64");
    for (const float height : {1e-1f, 1e-2f, 1e-3f, 1e-4f}) {
        SceneBuilder b;
        addFloor(b, b.material("floor", 0.5f, 0));
        b.quad(b.material("lamp", 0, 1e6f), {0.4f, height, -0.1f}, {0.2f, 0, 0}, {0, 0, 0.2f}); // x cross z is down
        b.scene.cameras = {above({-0.5f, 0, 0}, 0.01f, 1)};
        Bench s(b.scene, {});
        const int steps = 200;
        double truth = 0; // the patch is so small that its middle stands for it, to 1e-4 of its size squared
        for (int j = 0; j < steps; ++j)
            for (int i = 0; i < steps; ++i) {
                const glm::dvec3 offset(0.9 + 0.2 * (i + 0.5) / steps, height, -0.1 + 0.2 * (j + 0.5) / steps);
                const double r2 = glm::dot(offset, offset);
                truth += double(height) * height / (r2 * r2) * 0.04 / (steps * steps);
            }
        truth *= 1e6 * 0.5 / glm::pi<double>();
        const MeanError mean = meanOver(s, viewOf(s.scene, 4, 4), 256, 16);
        bias.add(mean.mean, mean.standardError, truth, truth * (5e-4 + 2e-7 / double(height)),
                 [&] { return "height " + std::to_string(height) + ": " + std::to_string(mean.mean) + " +- " + std::to_string(mean.standardError) + " truth " + std::to_string(truth); });
        EXPECT_EQ(dropped(s), 0u);
    }
}

// A plane that emits and reflects does not light itself.
TEST(ExtremeTransport, LampInItsOwnPlane) {
    Worst worst("image | plane that emits and reflects | 4 segments, scene 1e-4 to 1e6 units, askew", "its emission", 1e-4);
    for (const float scale : {1e-4f, 1.0f, 1e6f}) {
        SceneBuilder b;
        const std::uint32_t m = b.material("plane", 1, 2);
        addFloor(b, m);
        b.scene.cameras = {above({}, 0.9f, 1)};
        const glm::mat4 turn = glm::scale(glm::rotate(glm::mat4(1), 0.7f, glm::normalize(glm::vec3(1, 2, 0.5f))), glm::vec3(scale));
        for (glm::vec3& p : b.scene.geometry.positions) p = glm::vec3(turn * glm::vec4(p, 1));
        Camera& camera = b.scene.cameras[0];
        const glm::vec3 place(turn * camera.toWorld[3]);
        camera.toWorld = glm::mat4(glm::mat3(glm::rotate(glm::mat4(1), 0.7f, glm::normalize(glm::vec3(1, 2, 0.5f)))) * glm::mat3(camera.toWorld));
        camera.toWorld[3] = glm::vec4(place, 1);
        camera.ymag *= scale;
        RenderConfig config;
        config.maxDepth = 4;
        Bench s(b.scene, {}, config);
        for (const float v : s.renderer->render(viewOf(s.scene, 32, 32), 64, {1, 0, 0}, s.plan, &s.result).values)
            worst.compare(double(v), 2, [&] { return "scale " + std::to_string(scale) + ": " + std::to_string(v); });
        EXPECT_EQ(dropped(s), 0u);
    }
}

// In a closed box whose faces emit and reflect alike, L = Le (1 - rho^D) / (1 - rho).
TEST(ExtremeTransport, Depth) {
    Bias bias("image | white furnace | depth 1 to 128", "geometric sum");
    for (const int depth : {1, 2, 16, 128}) {
        RenderConfig config;
        config.maxDepth = std::uint32_t(depth);
        Bench s(bundledScene("furnace"), {}, config);
        const double rho = double(s.scene.parameters[s.scene.select("*.baseColor").at(0)].values[0]);
        const double emitted = double(s.scene.parameters[s.scene.select("*.emission").at(0)].values[0]);
        const double truth = emitted * (1 - std::pow(rho, depth)) / (1 - rho);
        // Of eight passes the standard error itself is off by a quarter: four of them would be exceeded once in two hundred times.
        const MeanError mean = meanOver(s, viewOf(s.scene, 8, 8), 32, 64);
        bias.add(mean.mean, mean.standardError, truth, 1e-5 * truth, [&] { return "depth " + std::to_string(depth) + ": " + std::to_string(mean.mean) + " truth " + std::to_string(truth); });
        EXPECT_EQ(dropped(s), 0u);
    }
}

// Emission seen directly is the same in every sample; albedo and emission as denormal numbers are as if they were 0.
TEST(ExtremeTransport, ManyEqualSamples) {
    Worst worst("image | emission seen directly | 2^20 samples of a pixel, by the kernels", "the emission", 1e-6);
    Worst denormal("image | denormal emission and albedo | 1e-40", "0", 1e-37);
    for (const float emission : {0.1f, 1e-20f, 7e19f, 1e-40f}) {
        SceneBuilder b;
        addFloor(b, b.material("floor", 1e-40f, emission));
        b.scene.cameras = {above({}, 0.5f, 1)};
        RenderConfig config;
        config.maxDepth = 2;
        Bench s(b.scene, {}, config);
        const bool tiny = emission < 1e-30f;
        const Image image = s.renderer->render(viewOf(s.scene, 1, 1), tiny ? 16 : 1u << 20, {1, 0, 0}, s.plan, &s.result);
        for (const float v : image.values) {
            const auto where = [&] { return std::to_string(std::log10(emission)) + ": " + std::to_string(v); };
            if (tiny) denormal.add(std::abs(double(v)), where);
            else worst.compare(double(v), double(emission), where);
        }
        EXPECT_EQ(dropped(s), 0u);
    }
}

Scene texturedFloor(std::uint32_t edge, SlotKind kind) {
    SceneBuilder b;
    const std::uint32_t m = b.material("floor", 0.5f, 0);
    valueOf(b.scene, m, SlotKind::Specular).values = {1};
    addFloor(b, m);
    b.scene.cameras = {above({}, 0.9f, 1)};
    b.scene.lights = {PunctualLight{}};
    b.scene.lights[0].position = {0.3f, 1, 0.2f};
    Parameter& p = valueOf(b.scene, m, kind);
    p.width = p.height = edge;
    p.textured = true;
    p.values.assign(p.entries(), 0.6f);
    return b.scene;
}

// One texel is a constant.
TEST(ExtremeTextures, OneTexel) {
    Worst worst("texture | image of a textured floor | 1 x 1", "8 x 8 of one value", 1e-6);
    const auto image = [&](std::uint32_t edge) {
        Bench s(texturedFloor(edge, SlotKind::BaseColor), {});
        return s.renderer->render(viewOf(s.scene, 16, 16), 16, {1, 0, 0}, s.plan, &s.result);
    };
    const Image one = image(1), many = image(8);
    for (std::size_t i = 0; i < one.values.size(); ++i) worst.compare(double(one.values[i]), double(many.values[i]), [&] { return std::to_string(i); });
}

TEST(ExtremeTextures, FullLargest) {
    Worst sum("texture | gradient along 1 of a roughness texture | 8192 x 8192", "derivative image", 1e-4);
    Worst value("texture | image of a textured floor | 8192 x 8192", "8 x 8 of one value", 1e-6);
    Bench s(texturedFloor(8192, SlotKind::Roughness), {"floor.roughness"}), small(texturedFloor(8, SlotKind::Roughness), {"floor.roughness"});
    const View view = viewOf(s.scene, 32, 32);
    const Image image = s.renderer->render(view, 16, {1, 0, 0}, s.plan, &s.result), truth = small.renderer->render(viewOf(small.scene, 32, 32), 16, {1, 0, 0}, small.plan, &small.result);
    for (std::size_t i = 0; i < image.values.size(); ++i) value.compare(double(image.values[i]), double(truth.values[i]), [&] { return std::to_string(i); });
    std::vector<std::vector<double>> gradients;
    s.result = s.renderer->reverse(view, 16, {1, 0, 1}, Image(32, 32, 3, 1.0f), {}, {}, gradients, s.plan);
    double total = 0;
    for (const double g : gradients[0]) total += g;
    const Image forward = s.renderer->forward(view, 16, {1, 0, 1}, s.config.differentiable, s.ones(), s.plan, &s.result);
    sum.compare(total, meanOf(forward) * double(forward.values.size()), [&] { return std::to_string(total); });
}

} // namespace
} // namespace cmpg::test

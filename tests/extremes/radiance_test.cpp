// Radiance of all scales through whole passes: images, derivatives both ways, the guide, the estimate of the variance.
#include "support/guided_fixture.h"
#include "worst.h"

#include <glm/gtc/matrix_transform.hpp>
#include <numeric>

namespace cmpg::test {
namespace {

std::uint64_t dropped(const Renderer& renderer) {
    std::uint64_t sum = 0;
    for (const auto& [kind, count] : renderer.statistics().dropped) sum += count;
    return sum;
}

double largest(const std::vector<float>& values) {
    double most = 0;
    for (const float v : values) most = std::max(most, std::abs(double(v)));
    return most;
}

// Powers of two, so that scaling rounds nothing: 7e-21 to 1.5e20.
constexpr float kScales[] = {0x1p-67f, 0x1p-33f, 0x1p33f, 0x1p67f};

struct Result {
    Image image, forward;
    std::vector<std::vector<double>> gradients;
    double variance = 0, gradientVariance = 0;
    std::uint64_t dropped = 0;
};

// Passes at any scale by one renderer.
class Passes {
  public:
    explicit Passes(const std::string& name) : s_(bundledScene(name), {"*.baseColor", "*.roughness", "*.normal"}, guidedConfig(4)), untrained_(s_.renderer->guide()) {
        for (std::uint32_t p = 0; p < s_.scene.parameters.size(); ++p) {
            Parameter& parameter = s_.scene.parameters[p];
            if (parameter.kind != SlotKind::Emission && parameter.kind != SlotKind::Radiance) continue;
            parameter.materialise();
            if (largest(parameter.values) > 0) lights_.emplace_back(p, parameter.values);
        }
    }

    // Learns for two passes, then draws from the guide.
    Result run(float scale, float adjointScale) {
        for (const auto& [p, values] : lights_) {
            std::vector<float> scaled = values;
            for (float& v : scaled) v *= scale;
            s_.renderer->setParameter(p, scaled);
        }
        s_.renderer->setGuide(untrained_);
        const View view = viewOf(s_.scene, 12, 12);
        const Image adjoint(12, 12, 3, adjointScale);
        const std::uint64_t before = dropped(*s_.renderer);
        std::vector<std::vector<double>> ignored;
        for (std::uint32_t i = 0; i < 2; ++i) {
            s_.plan = {.record = true};
            s_.result = s_.renderer->reverse(view, 8, {77, i, 3}, adjoint, {}, {}, ignored, s_.plan);
            s_.renderer->updateGuide();
        }
        s_.plan = {.method = {Sampling::Conditional}};
        Result r;
        r.image = s_.renderer->render(view, 8, {1, 0, 0}, s_.plan, &s_.result);
        r.variance = s_.result.variance;
        r.forward = s_.renderer->forward(view, 8, {1, 0, 1}, s_.config.differentiable, s_.ones(), s_.plan, &s_.result);
        s_.plan = {.method = {Sampling::Conditional}, .measure = true};
        s_.result = s_.renderer->reverse(view, 8, {1, 0, 1}, adjoint, {}, {}, r.gradients, s_.plan);
        r.gradientVariance = s_.result.variance;
        r.dropped = dropped(*s_.renderer) - before;
        return r;
    }

  private:
    Bench s_;
    SdTree untrained_;
    std::vector<std::pair<std::uint32_t, std::vector<float>>> lights_;
};

class ExtremeRadiance : public testing::TestWithParam<std::string> {};

// All is linear in the light and in the adjoint, so the truth is the result at scale 1, of the same samples. The guide learns and draws,
// in units of a pilot image.
TEST_P(ExtremeRadiance, ScalesThroughAllPasses) {
    const std::string range = " | radiance 7e-21 to 1.5e20, scene " + GetParam();
    Worst image("pass | image" + range, "scale 1", 1e-4), forward("pass | derivative image" + range, "scale 1", 1e-4);
    Worst reverse("pass | gradient" + range, "scale 1", 1e-4), variance("pass | variance of image and gradient" + range, "scale 1", 1e-4);
    Worst adjoints("pass | gradient | adjoints 7e-21 to 1e15, scene " + GetParam(), "scale 1", 1e-4);
    Worst lost("pass | contributions dropped or saturated" + range, "0", 0);
    Passes passes(GetParam());
    const Result base = passes.run(1, 1);
    const double imageSize = meanOf(base.image), forwardSize = largest(base.forward.values);
    const auto compareGradients = [&](Worst& worst, const Result& r, double scale) {
        for (std::size_t p = 0; p < r.gradients.size(); ++p) {
            double size = 0;
            for (const double g : base.gradients[p]) size = std::max(size, std::abs(g));
            for (std::size_t k = 0; k < r.gradients[p].size(); ++k)
                worst.compare(r.gradients[p][k] / scale, base.gradients[p][k], [&] { return "scale " + std::to_string(std::log2(scale)) + " parameter " + std::to_string(p); }, size);
        }
    };
    for (const float scale : kScales) {
        const Result r = passes.run(scale, 1);
        const auto where = [&] { return "scale 2^" + std::to_string(std::log2(scale)); };
        for (std::size_t i = 0; i < r.image.values.size(); ++i) {
            image.compare(double(r.image.values[i]) / double(scale), double(base.image.values[i]), where, imageSize);
            forward.compare(double(r.forward.values[i]) / double(scale), double(base.forward.values[i]), where, forwardSize);
        }
        compareGradients(reverse, r, double(scale));
        variance.compare(r.gradientVariance / double(scale) / double(scale), base.gradientVariance, where);
        variance.compare(r.variance / double(scale) / double(scale), base.variance, where);
        lost.add(double(r.dropped), where);
    }
    for (const float scale : {0x1p-67f, 0x1p50f}) {
        const Result r = passes.run(1, scale);
        compareGradients(adjoints, r, double(scale));
        lost.add(double(r.dropped), [&] { return "adjoints 2^" + std::to_string(std::log2(scale)); });
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, ExtremeRadiance, testing::Values("box", "environment"), [](const auto& scene) { return scene.param; });

// Lamps 1e6 : 1 in one room: both modes contract the same samples, so one is the other's truth.
TEST(ExtremeContrast, ForwardAgreesWithReverse) {
    Worst worst("pass | gradient along a direction | lights 1e6 : 1 in one scene, all slots", "derivative image", 1e-4);
    Scene scene = bundledScene("materials");
    for (PunctualLight& l : scene.lights) l.intensity *= 1e6f;
    for (std::size_t k = 0; Parameter& p : scene.parameters)
        if (p.kind == SlotKind::Emission) {
            p.materialise();
            for (float& v : p.values) v *= k % 2 ? 1e6f : 1.0f;
            ++k;
        }
    Bench s(std::move(scene), {"*"});
    const View view = viewOf(s.scene, 16, 16);
    const std::vector<std::vector<float>> ones = s.ones();
    Image adjoint(16, 16, 3);
    std::mt19937 random(2);
    for (float& a : adjoint.values) a = float(random()) * 0x1p-32f;
    std::vector<std::vector<double>> gradients;
    s.result = s.renderer->reverse(view, 16, {5, 0, 1}, adjoint, {}, {}, gradients, s.plan);
    for (std::size_t i = 0; i < ones.size(); ++i) {
        const Image forward = s.renderer->forward(view, 16, {5, 0, 1}, std::span(&s.config.differentiable[i], 1), std::span(&ones[i], 1), s.plan, &s.result);
        double along = 0, size = 0;
        for (std::size_t k = 0; k < adjoint.values.size(); ++k) {
            along += double(forward.values[k]) * double(adjoint.values[k]);
            size += std::abs(double(forward.values[k]) * double(adjoint.values[k]));
        }
        worst.compare(std::accumulate(gradients[i].begin(), gradients[i].end(), 0.0), along, [&] { return s.scene.parameters[s.config.differentiable[i]].name; }, size);
    }
    EXPECT_EQ(dropped(*s.renderer), 0u);
}

// A black room tells nothing of the size of its derivatives: the pass is run again in coarser units until the sums fit.
TEST(ExtremeSums, NearSaturation) {
    Worst worst("sum | gradient in a black room, lamp 1 to 2^40 | integer sums up to and beyond 2^62", "lamp 1", 1e-4);
    Scene scene = bundledScene("box");
    std::uint32_t lamp = 0;
    for (std::uint32_t i = 0; i < scene.parameters.size(); ++i) {
        Parameter& p = scene.parameters[i];
        p.materialise();
        if (p.kind == SlotKind::BaseColor) std::fill(p.values.begin(), p.values.end(), 0.0f);
        if (p.kind == SlotKind::Emission && largest(p.values) > 0) lamp = i;
    }
    const std::vector<float> emission = scene.parameters[lamp].values;
    scene.cameras.front().toWorld = glm::translate(glm::mat4(1), glm::vec3(0, 1, 0.5f)) * glm::rotate(glm::mat4(1), -1.5f, glm::vec3(1, 0, 0)); // at the floor
    RenderConfig config;
    config.maxDepth = 3;
    Bench s(std::move(scene), {"white.baseColor"}, config);
    double base = 0;
    for (int exponent = 0; exponent <= 40; exponent += 4) {
        std::vector<float> values = emission;
        for (float& v : values) v = std::ldexp(v, exponent);
        s.renderer->setParameter(lamp, values);
        std::vector<std::vector<double>> g;
        s.result = s.renderer->reverse(viewOf(s.scene, 12, 12), 8, {3, 0, 1}, Image(12, 12, 3, 1.0f), {}, {}, g, s.plan);
        const double scaled = std::ldexp(g[0][0], -exponent);
        if (exponent == 0) base = scaled;
        worst.compare(scaled, base, [&] { return "2^" + std::to_string(exponent); });
    }
    EXPECT_GT(base, 0);
    EXPECT_EQ(dropped(*s.renderer), 0u);
}

} // namespace
} // namespace cmpg::test

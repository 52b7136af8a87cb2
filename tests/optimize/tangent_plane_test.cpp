// Steps of normals in their tangent planes, and recoveries of normal maps by Gauss-Newton.
#include "linear_model.h"
#include "optimize/optimize.h"
#include "optimize/tangent_plane.h"

#include <gtest/gtest.h>
#include <numbers>

namespace cmpg::test {
namespace {

using Vector = std::array<float, 3>;

double dot(const float* a, const Vector& b) { return double(a[0]) * b[0] + double(a[1]) * b[1] + double(a[2]) * b[2]; }
double length(const float* n) { return std::sqrt(dot(n, {n[0], n[1], n[2]})); }

// The light of a direction on a matt surface, unclamped, and its derivative by a normal of any length.
double lit(const float* n, const Vector& light) { return dot(n, light) / length(n); }
double litBy(const float* n, const Vector& light, std::size_t component) {
    return (light[component] - lit(n, light) * n[component] / length(n)) / length(n);
}

// Along the axes, between them, of any length.
std::vector<float> someNormals() {
    std::vector<float> normals = {0, 0, 1, 1, 0, 0, 0, -1, 0, 0, 0, -1, -0.999f, 0.01f, -0.02f};
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    for (int i = 0; i < 30; ++i)
        normals.push_back(normal(random));
    return normals;
}

TEST(TangentPlane, DerivativesBySteps) {
    const Vector light{0.3f, -0.5f, 0.8f};
    const std::vector<float> normals = someNormals();
    std::vector<double> derivatives;
    for (std::size_t i = 0; i < normals.size(); ++i)
        derivatives.push_back(litBy(normals.data() + i / 3 * 3, light, i % 3));
    std::vector<double> found = derivatives;
    toSteps(normals, found);
    for (std::size_t axis = 0; axis < 2; ++axis) {
        constexpr float kStep = 0.01f;
        std::vector<float> steps(normals.size()), up = normals, down = normals;
        for (std::size_t i = axis; i < steps.size(); i += 3)
            steps[i] = kStep;
        moveNormals(steps, up);
        for (float& step : steps)
            step = -step;
        moveNormals(steps, down);
        std::vector<double> ofAxis = found;
        dropOtherAxis(axis, ofAxis);
        for (std::size_t t = 0; t < normals.size() / 3; ++t) {
            EXPECT_NEAR(found[3 * t + axis], (lit(up.data() + 3 * t, light) - lit(down.data() + 3 * t, light)) / (2 * kStep), 2e-4) << t;
            EXPECT_EQ(ofAxis[3 * t + axis], found[3 * t + axis]);
            EXPECT_EQ(ofAxis[3 * t + 1 - axis], 0);
            EXPECT_EQ(found[3 * t + 2], 0);
        }
    }
}

TEST(TangentPlane, StepsKeepUnitLength) {
    const std::vector<float> normals = someNormals();
    std::vector<float> steps(normals.size(), 0.f), same = normals, moved = normals;
    moveNormals(steps, same);
    steps.assign(steps.size(), 0.7f);
    moveNormals(steps, moved);
    for (std::size_t t = 0; t < normals.size(); t += 3) {
        const float *n = normals.data() + t, *s = same.data() + t, *m = moved.data() + t;
        EXPECT_NEAR(length(s), 1, 1e-6);
        EXPECT_NEAR(dot(n, {s[0], s[1], s[2]}), length(n), 1e-5);
        EXPECT_NEAR(length(m), 1, 1e-6);
        EXPECT_NEAR(dot(s, {m[0], m[1], m[2]}), 1 / std::sqrt(1 + 2 * 0.7 * 0.7), 1e-5);
    }
    std::vector<float> none(3, 0.f);
    moveNormals(std::vector<float>(3, 0.f), none);
    EXPECT_EQ(none, (std::vector<float>{0, 0, 1})); // the surface's own
}

// A matt wall, each of whose pixels sees a texel of its normal map; red, green and blue light come from different sides.
class LitWall final : public ImageModel {
  public:
    static constexpr int kSize = 12;

    LitWall(std::vector<float> normals, double noise) : normals_(normals), second_(std::move(normals)), noise_(noise) {}

    std::size_t views() const override { return 1; }
    std::pair<int, int> size(std::size_t) const override { return {kSize, kSize}; }
    Image picture(std::size_t, std::uint32_t spp, const PassKey& key, bool) override { return image(normals_, spp, key); }
    ImageHalves renderHalves(std::size_t, std::uint32_t spp, const PassKey& key, bool, const SampleRanges& samples) override {
        const std::span<const std::uint32_t> counts = samples.counts;
        ImageHalves halves{{}, std::max(1u, spp / 2), {counts.begin(), counts.end()}};
        for (std::uint32_t h = 0; h < 2; ++h) {
            const PassKey own{key.seed, key.step, key.pass + 5 * h, key.firstSample};
            halves.half[h].image = image(normals_, halves.samples, own);
            halves.half[h].difference = image(second_, halves.samples, own);
            for (std::size_t i = 0; i < halves.half[h].image.values.size(); ++i)
                halves.half[h].difference.values[i] = halves.half[h].image.values[i] - halves.half[h].difference.values[i];
        }
        return halves;
    }
    void setSecondValues(std::uint32_t, std::span<const float> values) override { second_.assign(values.begin(), values.end()); }
    void setParameter(std::uint32_t, std::span<const float> values) override { normals_.assign(values.begin(), values.end()); }
    std::uint64_t reverse(std::size_t, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients) override {
        Noise noise(key, noise_ / std::sqrt(spp));
        for (std::size_t i = 0; i < normals_.size(); ++i) {
            const float* n = normals_.data() + i / 3 * 3;
            const double factor = lit(n, kLights[i % 3]) > 0 ? adjoint.values[i] * noise() : 0;
            for (std::size_t c = 0; c < 3; ++c)
                gradients[0][i / 3 * 3 + c] += factor * litBy(n, kLights[i % 3], c);
        }
        return spp * std::uint64_t(kSize) * kSize;
    }
    std::uint64_t reverseHalves(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients,
                                std::vector<std::vector<double>>& half) override {
        std::vector<std::vector<double>> first{std::vector<double>(normals_.size())}, second = first;
        reverse(view, std::max(1u, spp / 2), key, adjoint, first);
        reverse(view, std::max(1u, spp / 2), {key.seed, key.step, key.pass + 5}, adjoint, second);
        for (std::size_t i = 0; i < normals_.size(); ++i) {
            gradients[0][i] += 0.5 * (first[0][i] + second[0][i]);
            half[0][i] += 0.5 * (first[0][i] - second[0][i]);
        }
        return spp * std::uint64_t(kSize) * kSize;
    }

  private:
    static constexpr std::array<Vector, 3> kLights{{{0.6f, 0, 0.8f}, {-0.36f, 0.48f, 0.8f}, {-0.36f, -0.48f, 0.8f}}};

    struct Noise {
        std::mt19937_64 random;
        std::normal_distribution<double> normal;
        Noise(const PassKey& key, double deviation) : normal(1, deviation) {
            std::seed_seq seed{std::uint32_t(key.seed), key.step, key.pass, key.firstSample};
            random.seed(seed);
        }
        double operator()() { return normal(random); }
    };
    Image image(const std::vector<float>& normals, std::uint32_t spp, const PassKey& key) const {
        Noise noise(key, noise_ / std::sqrt(spp));
        Image image(kSize, kSize, 3);
        for (std::size_t i = 0; i < normals.size(); ++i)
            image.values[i] = float(std::max(0.0, lit(normals.data() + i / 3 * 3, kLights[i % 3])) * noise());
        return image;
    }

    std::vector<float> normals_, second_;
    double noise_;
};

// Round stones, as steep as 40 degrees.
std::vector<float> stones() {
    std::vector<float> normals;
    for (int y = 0; y < LitWall::kSize; ++y)
        for (int x = 0; x < LitWall::kSize; ++x) {
            const float u = 0.6f * std::sin(1.1f * float(x)), v = 0.5f * std::cos(0.9f * float(y)), scale = 1 / std::sqrt(1 + u * u + v * v);
            normals.insert(normals.end(), {u * scale, v * scale, scale});
        }
    return normals;
}

// Mean angle to the true normals after so many steps, in degrees.
double angleAfter(OptimizerKind kind, std::uint32_t steps, double noise) {
    const std::vector<float> truth = stones();
    Scene scene;
    scene.parameters.push_back(makeParameter("wall.normal", SlotKind::Normal, LitWall::kSize, LitWall::kSize, 3, 0));
    Parameter& map = scene.parameters[0];
    for (std::size_t i = 2; i < map.values.size(); i += 3)
        map.values[i] = 0.5f; // not yet unit
    LitWall model(map.values, noise), target(truth, 0);
    OptimizeConfig config;
    config.optimizer.kind = kind;
    config.targets.resize(1);
    config.targets[0].image = target.picture(0, 1, {}, false);
    Optimization run(model, scene, config, {0});
    while (run.state().step < steps)
        run.step();
    double sum = 0;
    for (std::size_t t = 0; t < truth.size(); t += 3) {
        EXPECT_NEAR(length(map.values.data() + t), 1, 1e-5);
        sum += std::acos(std::min(1.0, dot(map.values.data() + t, {truth[t], truth[t + 1], truth[t + 2]})));
    }
    return sum / double(truth.size() / 3) * 180 / std::numbers::pi;
}

TEST(TangentPlane, GaussNewtonFindsNormals) {
    constexpr double kNoise = 0.3; // of a sample
    EXPECT_LT(angleAfter(OptimizerKind::Auto, 40, 0), 0.1);
    EXPECT_LT(angleAfter(OptimizerKind::Auto, 20, kNoise), 0.5 * angleAfter(OptimizerKind::Adam, 20, kNoise));
    EXPECT_LT(angleAfter(OptimizerKind::Auto, 60, kNoise), angleAfter(OptimizerKind::Adam, 60, kNoise)); // when Adam is near as well
}

} // namespace
} // namespace cmpg::test

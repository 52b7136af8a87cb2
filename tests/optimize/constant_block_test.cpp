// Newton steps of constants: against quadratics written out, against finite differences of a loss, and on a surface whose parameters can stand in for each other.
#include "linear_model.h"
#include "optimize/constant_block.h"
#include "optimize/gauss_newton.h"
#include "optimize/optimize.h"

#include <gtest/gtest.h>

namespace cmpg::test {
namespace {

// Symmetric, with eigenvalues from `scale` down to a thousandth of it: R^T D R with R orthogonal, of reflections.
std::vector<double> randomMatrix(std::size_t count, double scale, std::mt19937& random) {
    std::normal_distribution<double> normal;
    std::vector<double> matrix(count * count);
    for (std::size_t i = 0; i < count; ++i)
        matrix[i * count + i] = scale * std::pow(10, -3 * double(i) / double(count - 1));
    for (int k = 0; k < 3; ++k) {
        std::vector<double> v(count);
        double length = 0;
        for (double& x : v) {
            x = normal(random);
            length += x * x;
        }
        const auto reflect = [&](std::size_t first, std::size_t stride) {
            double along = 0;
            for (std::size_t i = 0; i < count; ++i)
                along += v[i] * matrix[first + i * stride];
            for (std::size_t i = 0; i < count; ++i)
                matrix[first + i * stride] -= 2 * along / length * v[i];
        };
        for (std::size_t i = 0; i < count; ++i)
            reflect(i, count);
        for (std::size_t i = 0; i < count; ++i)
            reflect(i * count, 1);
    }
    return matrix;
}

double slopeAt(std::span<const double> matrix, std::span<const double> gradient, std::span<const double> x, std::size_t i) {
    double sum = gradient[i];
    for (std::size_t k = 0; k < x.size(); ++k)
        sum += matrix[i * x.size() + k] * x[k];
    return sum;
}

TEST(ConstantBlock, FindsTheMinimumOfAQuadratic) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (const double scale : {1e-17, 1.0, 1e12}) {
        constexpr std::size_t kCount = 6;
        const std::vector<double> matrix = randomMatrix(kCount, scale, random);
        std::vector<double> minimum(kCount), gradient(kCount, 0.0);
        for (double& m : minimum)
            m = uniform(random);
        for (std::size_t i = 0; i < kCount; ++i)
            gradient[i] = -slopeAt(matrix, std::vector<double>(kCount, 0.0), minimum, i);
        const std::vector<double> far(kCount, 3.0), away(kCount, -3.0);
        const std::vector<double> found = boxMinimum(matrix, gradient, away, far);
        for (std::size_t i = 0; i < kCount; ++i)
            EXPECT_NEAR(found[i], minimum[i], 5e-3) << scale;
    }
}

// Where a bound holds a value the slope goes outwards, and is 0 elsewhere (Karush, Kuhn and Tucker).
TEST(ConstantBlock, StaysWithinBounds) {
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    int held = 0;
    for (int trial = 0; trial < 50; ++trial) {
        constexpr std::size_t kCount = 5;
        const std::vector<double> matrix = randomMatrix(kCount, 1, random), lowest(kCount, -0.2), highest(kCount, 0.1);
        std::vector<double> gradient(kCount);
        for (double& g : gradient)
            g = 0.1 * normal(random);
        const std::vector<double> x = boxMinimum(matrix, gradient, lowest, highest);
        for (std::size_t i = 0; i < kCount; ++i) {
            const double slope = slopeAt(matrix, gradient, x, i);
            ASSERT_TRUE(x[i] >= lowest[i] && x[i] <= highest[i]);
            if (x[i] == lowest[i])
                EXPECT_GE(slope, -1e-5);
            else if (x[i] == highest[i])
                EXPECT_LE(slope, 1e-5);
            else
                EXPECT_NEAR(slope, 0, 1e-5);
            held += x[i] == lowest[i] || x[i] == highest[i];
        }
    }
    EXPECT_GT(held, 50);
}

// Entries that no path met, or whose measurement is all noise, stay.
TEST(ConstantBlock, LeavesWhatIsNotKnown) {
    const std::vector<double> bound(2, 1.0), below(2, -1.0), gradient{0.1, 0.1};
    for (const double none : {0.0, -1.0, std::nan("")}) {
        const std::vector<double> matrix{1, 0, 0, none};
        EXPECT_EQ(boxMinimum(matrix, gradient, below, bound), (std::vector<double>{-0.1, 0})) << none;
    }
}

Image randomImage(int size, std::mt19937& random, double deviation) {
    std::normal_distribution<float> normal(0, float(deviation));
    Image image(size, size, 3);
    for (float& value : image.values)
        value = normal(random);
    return image;
}

// Columns are one number and a colour; the Hessian of the loss of `base` + columns is known from differences of the loss itself.
TEST(ConstantBlock, ProductsAreTheHessianOfTheLoss) {
    std::mt19937 random(3);
    constexpr int kSize = 8;
    const Image number = randomImage(kSize, random, 1), colour = randomImage(kSize, random, 1);
    const std::vector<ConstantColumn> columns{{{number, number}, 1, 0.5}, {{colour, colour}, 3, -0.25}};
    Target target;
    target.image = randomImage(kSize, random, 1);
    target.mask.resize(kSize * kSize);
    for (std::size_t i = 0; i < target.mask.size(); ++i)
        target.mask[i] = float(i % 5) / 4;
    for (const Loss loss : {Loss::Mse, Loss::RelativeMse}) {
        ConstantProducts products(4);
        addProducts(columns, lossCurvature(loss, target.image, target.mask), products);
        const auto lossAt = [&](std::array<double, 4> x) {
            Image image = target.image;
            for (std::size_t i = 0; i < image.values.size(); ++i)
                image.values[i] += float(x[0] * number.values[i] / 0.5 + x[1 + i % 3] * colour.values[i] / -0.25);
            return evaluateLoss(loss, image, target.image, target.mask).value;
        };
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < 4; ++j) {
                std::array<double, 4> plus{}, minus{};
                plus[i] += 1;
                plus[j] += 1;
                minus[i] += 1;
                minus[j] -= 1;
                EXPECT_NEAR(products.mean[4 * i + j], 0.5 * (lossAt(plus) - lossAt(minus)), 1e-4 * products.mean[0]) << i << ", " << j; // exact for a quadratic with its minimum at 0
            }
    }
}

// Halves with noise of their own: the curvature has no bias by it, and says how far off it is.
TEST(ConstantBlock, KnowsItsNoise) {
    std::mt19937 random(4);
    constexpr int kSize = 32;
    const Image a = randomImage(kSize, random, 1), b = randomImage(kSize, random, 0.1);
    Image weight(kSize, kSize, 3, 1.0f / (kSize * kSize * 3));
    ConstantProducts truth(2);
    addProducts(std::vector<ConstantColumn>{{{a, a}, 1, 1}, {{b, b}, 1, 1}}, weight, truth);
    const auto noisy = [&](const Image& image) {
        ConstantColumn column{{image, image}, 1, 1};
        for (Image& half : column.half)
            for (std::size_t i = 0; i < half.values.size(); ++i)
                half.values[i] += randomImage(1, random, 0.5).values[0];
        return column;
    };
    std::vector<double> mean(4), off(4), said(4);
    constexpr int kTrials = 256;
    for (int trial = 0; trial < kTrials; ++trial) {
        ConstantProducts products(2);
        const std::vector<ConstantColumn> columns{noisy(a), noisy(b)};
        addProducts(columns, weight, products);
        ConstantCurvature curvature;
        curvature.add(products, std::vector<float>(2), std::vector<double>(2, 1.0));
        for (std::size_t i = 0; i < 4; ++i) {
            mean[i] += curvature.matrix[i] / kTrials;
            off[i] += std::pow(curvature.matrix[i] - truth.mean[i], 2) / kTrials;
            said[i] += std::pow(curvature.noise[i], 2) / kTrials;
        }
    }
    // Four standard errors: of a mean of so many trials, and of a mean of as many squares of a normal distribution.
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(mean[i], truth.mean[i], 4 * std::sqrt(off[i] / kTrials)) << i;
        EXPECT_NEAR(said[i] / off[i], 1, 4 * std::sqrt(2.0 / kTrials)) << i;
    }
}

ConstantCurvature measured(double found, double variance) {
    ConstantCurvature curvature;
    ConstantProducts products(1);
    products.mean[0] = found;
    products.variance[0] = variance;
    curvature.add(products, std::vector<float>{0.5f}, std::vector<double>{1});
    return curvature;
}

Moments momentsOfConstants() {
    Moments moments;
    moments.noise.resize(1);
    return moments;
}

// Noise may make a measured diagonal negative, or all but 0. The entry takes a step then, as short as that noise asks for.
TEST(ConstantBlock, StepsWhereNoiseHidesTheCurvature) {
    const std::vector<double> gradient{-1}, none{0}, below{-10}, bound{10}, rate{0.1};
    for (const double found : {-0.5, 0.0, 1e-6}) {
        Moments moments = momentsOfConstants();
        EXPECT_NEAR(constantStep(measured(found, 4), gradient, none, below, bound, rate, moments)[0], 0.5, 1e-3) << found;
    }
}

// However noisy the curvature is, a slope that is sure goes its rate, and one that may be of either sign hardly moves.
TEST(ConstantBlock, GoesItsRateWhereNoiseHidesTheCurvature) {
    const std::vector<double> gradient{-1}, below{-10}, bound{10}, rate{0.1};
    const auto step = [&](double half, double found) {
        Moments moments = momentsOfConstants();
        return constantStep(measured(found, 1e8), gradient, std::vector<double>{half}, below, bound, rate, moments)[0];
    };
    EXPECT_NEAR(step(0, 0), 0.1, 1e-12);
    EXPECT_NEAR(step(0.5, -1), 0.075, 1e-12);
    EXPECT_NEAR(step(0, 100), 0.01, 1e-12); // what it says, if it is right
    EXPECT_NEAR(step(2, 0), 0, 1e-3);
}

// Noise averages out over steps of the same values; gradients of values far from those count less.
TEST(ConstantBlock, CarriesTheGradientWhereNoiseHidesTheCurvature) {
    const ConstantCurvature curvature = measured(0, 4);
    const std::vector<double> range{0.1};
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    constexpr int kSteps = 100;
    CarriedGradient carried;
    for (int step = 0; step < kSteps; ++step) {
        const double a = 1 + 2 * normal(random), b = 1 + 2 * normal(random); // two halves
        carried.advance(curvature, std::vector<float>{0.5f}, range, std::vector<double>{0.5 * (a + b)}, std::vector<double>{0.5 * (a - b)});
    }
    EXPECT_NEAR(carried.mean[0], 1, 4 * std::sqrt(2.0 / kSteps)); // four standard errors of a plain mean
    EXPECT_LT(carried.variance[0], 4 * 2.0 / kSteps);
    const auto after = [&](float at, double hides) {
        CarriedGradient moved = carried;
        ConstantCurvature other = curvature;
        other.noise[0] = hides;
        moved.advance(other, std::vector<float>{at}, range, std::vector<double>{-3}, std::vector<double>{0.1});
        return moved.mean[0];
    };
    EXPECT_GT(after(0.5f, 2), 0.5);
    EXPECT_LT(after(0.6f, 2), after(0.5f, 2) - 1);
    EXPECT_EQ(after(0.5f, 0), -3);
}

// A lit sphere of one material, as one number each: base colour, metallic, specular and roughness. The highlight narrows with the roughness, gets the
// colour with metallic, and less of it remains diffuse: parameters raise pixels and lower them, and can stand in for each other.
class Surface final : public ImageModel {
  public:
    static constexpr int kWidth = 24;
    Surface(const Scene& scene, double noise) : noise_(noise) {
        for (const Parameter& parameter : scene.parameters)
            values_.push_back(parameter.values);
        second_ = values_;
    }
    std::size_t views() const override { return 1; }
    std::pair<int, int> size(std::size_t) const override { return {kWidth, kWidth}; }
    Image picture(std::size_t, std::uint32_t spp, const PassKey& key, bool) override { return image(spp, key, values_); }
    ImageHalves renderHalves(std::size_t, std::uint32_t spp, const PassKey& key, bool difference, const SampleRanges&) override {
        ImageHalves halves{{}, std::max(1u, spp / 2)};
        for (std::uint32_t h = 0; h < 2; ++h) {
            const PassKey own{key.seed, key.step, key.pass + 5 * h, key.firstSample};
            halves.half[h].image = image(halves.samples, own, values_);
            if (!difference)
                continue;
            halves.half[h].difference = halves.half[h].image;
            const Image other = image(halves.samples, own, second_);
            for (std::size_t i = 0; i < other.values.size(); ++i)
                halves.half[h].difference.values[i] -= other.values[i];
        }
        return halves;
    }
    void setSecondValues(std::uint32_t parameter, std::span<const float> values) override { second_.at(parameter).assign(values.begin(), values.end()); }
    void setParameter(std::uint32_t parameter, std::span<const float> values) override { values_.at(parameter).assign(values.begin(), values.end()); }
    std::uint64_t reverse(std::size_t, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients) override {
        constexpr float kStep = 1e-3f;
        for (std::size_t k = 0; k < values_.size(); ++k)
            for (std::size_t entry = 0; entry < values_[k].size(); ++entry) {
                std::vector<std::vector<float>> up = values_, down = values_;
                up[k][entry] += kStep;
                down[k][entry] -= kStep;
                const Image a = image(spp, key, up), b = image(spp, key, down);
                for (std::size_t i = 0; i < a.values.size(); ++i)
                    gradients[k][entry] += adjoint.values[i] * (double(a.values[i]) - b.values[i]) / (2 * kStep);
            }
        return spp * adjoint.pixels();
    }
    std::uint64_t reverseHalves(std::size_t view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients,
                                std::vector<std::vector<double>>& half) override {
        std::vector<std::vector<double>> each[2];
        for (std::uint32_t h = 0; h < 2; ++h) {
            for (const std::vector<double>& g : gradients)
                each[h].emplace_back(g.size());
            reverse(view, std::max(1u, spp / 2), {key.seed, key.step, key.pass + 5 * h}, adjoint, each[h]);
        }
        for (std::size_t k = 0; k < gradients.size(); ++k)
            for (std::size_t i = 0; i < gradients[k].size(); ++i) {
                gradients[k][i] += 0.5 * (each[0][k][i] + each[1][k][i]);
                half[k][i] += 0.5 * (each[0][k][i] - each[1][k][i]);
            }
        return spp * adjoint.pixels();
    }

  private:
    Image image(std::uint32_t spp, const PassKey& key, const std::vector<std::vector<float>>& values) const {
        std::seed_seq seed{std::uint32_t(key.seed), key.step, key.pass, key.firstSample};
        std::mt19937 random(seed);
        std::normal_distribution<double> normal(0, noise_ / std::sqrt(double(spp)));
        const std::vector<float>& colour = values[0];
        const double metallic = values[1][0], specular = values[2][0], width = 0.05 + values[3][0] * values[3][0];
        Image out(kWidth, kWidth, 3);
        for (int p = 0; p < kWidth * kWidth; ++p) {
            const double x = (p % kWidth + 0.5) / kWidth - 0.4, y = (p / kWidth + 0.5) / kWidth - 0.6, highlight = std::exp(-(x * x + y * y) / width) / width;
            const double diffuse = 0.3 + 0.7 * std::max(0.0, 1 - x - y) * 0.5, error = 1 + normal(random);
            for (int c = 0; c < 3; ++c)
                out.values[std::size_t(3 * p + c)] = float(error * ((1 - metallic) * colour[std::size_t(c)] * diffuse + (metallic * colour[std::size_t(c)] + (1 - metallic) * 0.08 * specular) * 0.3 * highlight));
        }
        return out;
    }

    double noise_;
    std::vector<std::vector<float>> values_, second_;
};

Scene surfaceScene(std::array<float, 6> values) {
    Scene scene;
    scene.parameters.push_back(makeParameter("ball.baseColor", SlotKind::BaseColor, 1, 1, 3, 0));
    scene.parameters.push_back(makeParameter("ball.metallic", SlotKind::Metallic, 1, 1, 1, values[3]));
    scene.parameters.push_back(makeParameter("ball.specular", SlotKind::Specular, 1, 1, 1, values[4]));
    scene.parameters.push_back(makeParameter("ball.roughness", SlotKind::Roughness, 1, 1, 1, values[5]));
    std::copy_n(values.begin(), 3, scene.parameters[0].values.begin());
    return scene;
}

// Root mean square of what is left after `steps`, from a start to a truth.
double left(OptimizerKind kind, std::array<float, 6> start, std::array<float, 6> truth, double noise, std::uint32_t steps) {
    Scene scene = surfaceScene(start);
    const Scene wanted = surfaceScene(truth);
    OptimizeConfig config;
    config.optimizer.kind = kind;
    config.sppDifference = 8;
    config.targets.resize(1);
    config.targets[0].image = Surface(wanted, 0).picture(0, 1, {}, false);
    Surface model(scene, noise);
    Optimization run(model, scene, config, {0, 1, 2, 3});
    while (run.state().step < steps)
        run.step();
    double squares = 0;
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t i = 0; i < wanted.parameters[k].values.size(); ++i)
            squares += std::pow(double(scene.parameters[k].values[i]) - wanted.parameters[k].values[i], 2) / 6;
    return std::sqrt(squares);
}

constexpr std::array<float, 6> kHalf{0.7f, 0.3f, 0.2f, 0.5f, 0.5f, 0.4f}, kGrey{0.5f, 0.5f, 0.5f, 0.1f, 0.1f, 0.7f}, kRough{0.1f, 0.9f, 0.5f, 0.9f, 0.9f, 0.95f},
    kSharp{0.9f, 0.9f, 0.9f, 0.2f, 0.3f, 0.1f};

TEST(ConstantBlock, RecoversWhatCanStandInForEachOther) {
    for (const std::array<float, 6>& start : {kGrey, kRough, kSharp})
        EXPECT_LT(left(OptimizerKind::Auto, start, kHalf, 0, 30), 1e-4) << start[0];
}

TEST(ConstantBlock, ComesNearerThanAdamInAsManySteps) {
    for (const std::array<float, 6>& start : {kGrey, kRough, kSharp}) {
        const double ours = left(OptimizerKind::Auto, start, kHalf, 0.3, 30), adam = left(OptimizerKind::Adam, start, kHalf, 0.3, 30);
        EXPECT_LT(ours, 0.5 * adam) << start[0];
    }
}

} // namespace
} // namespace cmpg::test

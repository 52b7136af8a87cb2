// Grids of coarser texels: what interpolation, sums and the total variation's bound on them mean.
#include "linear_model.h"
#include "optimize/coarse_texture.h"
#include "optimize/regularizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace cmpg::test {
namespace {

std::vector<float> randomValues(std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(-1, 1);
    std::vector<float> values(count);
    for (float& value : values)
        value = uniform(random);
    return values;
}

double inner(const std::vector<float>& a, const std::vector<float>& b) { return std::inner_product(a.begin(), a.end(), b.begin(), 0.0); }

std::vector<float> spread(const CoarseTexture& texture, const std::vector<float>& coarse) {
    std::vector<float> fine(texture.fine().entries());
    texture.spread(coarse, fine);
    return fine;
}

const TextureGrid kGrids[] = {{64, 64, 3, true, true}, {64, 64, 3, false, false}, {7, 5, 3, true, false}, {1, 9, 1, false, true}, {3, 1, 3, true, false}, {130, 2, 1, true, true}};

TEST(CoarseTexture, GatheringIsTheTransposeOfSpreading) {
    for (const TextureGrid& grid : kGrids) {
        const CoarseTexture texture(grid);
        EXPECT_EQ(texture.coarse().width, (grid.width + 3) / 4);
        EXPECT_EQ(texture.coarse().height, (grid.height + 3) / 4);
        const std::vector<float> fine = randomValues(grid.entries(), 1), coarse = randomValues(texture.coarse().entries(), 2);
        EXPECT_NEAR(inner(texture.gather(fine), coarse), inner(fine, spread(texture, coarse)), 1e-5 * double(grid.entries())) << grid.width << " x " << grid.height;
    }
}

TEST(CoarseTexture, ConstantsStayConstant) {
    for (const TextureGrid& grid : kGrids) {
        const CoarseTexture texture(grid);
        for (const float value : spread(texture, std::vector<float>(texture.coarse().entries(), 0.75f)))
            EXPECT_NEAR(value, 0.75f, 1e-6f) << grid.width << " x " << grid.height;
    }
}

TEST(CoarseTexture, MeansOfConstantsAreConstant) {
    for (const TextureGrid& grid : kGrids)
        for (const std::size_t factor : {2, 4, 16}) {
            const CoarseTexture texture(grid, factor);
            EXPECT_EQ(texture.coarse().width, (grid.width + factor - 1) / factor);
            for (const float value : texture.meanOf(std::vector<float>(grid.entries(), 0.75f)))
                EXPECT_NEAR(value, 0.75f, 1e-6f) << grid.width << " x " << grid.height;
            EXPECT_TRUE(texture.meanOf({}).empty());
        }
}

TEST(CoarseTexture, NearestIsTheTexelAround) {
    const CoarseTexture texture({8, 5, 3}, 4);
    EXPECT_EQ(texture.nearest(std::vector<bool>{true, false, false, true}), (std::vector<bool>{1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, // the middle row: the first
                                                                              0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 1, 1, 1, 1}));
}

// P^T L P of a texture without edges: its quadratic form at smooth values is that of the coarse pairs.
TEST(CoarseTexture, BoundOfSmoothValuesIsThatOfThePairsBetween) {
    for (const Wrap wrap : {Wrap::Repeat, Wrap::Clamp}) {
        Parameter parameter = makeParameter("m.baseColor", SlotKind::BaseColor, 128, 64, 1, 0.5f);
        parameter.wrapU = parameter.wrapV = wrap;
        TotalVariationBound fine(parameter);
        fine.add(parameter, 0.7, {0.01});
        const CoarseTexture texture(fine.grid());
        const TotalVariationBound coarse = fine.coarser(texture);
        constexpr double kPi = 3.14159265358979;
        std::vector<float> values;
        for (std::size_t y = 0; y < 16; ++y)
            for (std::size_t x = 0; x < 32; ++x) // waves without a slope where a texture ends
                values.push_back(float(std::cos(2 * kPi * (double(x) + 0.5) / 32) + std::cos(2 * kPi * (double(y) + 0.5) / 16)));
        const auto form = [](const TotalVariationBound& bound, const std::vector<float>& x) {
            std::vector<float> image(x.size());
            bound.multiply(std::vector<float>(x.size(), 0.f), x, image);
            return inner(x, image);
        };
        const double expected = form(fine, spread(texture, values)), found = form(coarse, values);
        EXPECT_GT(expected, 0);
        EXPECT_NEAR(found, expected, 0.05 * expected);
    }
}

} // namespace
} // namespace cmpg::test

// The scrambled Sobol sets: nets, even margins, independence between sets, and less variance than independent numbers.
#include "shader_double.h"

#include "statistics.h"

#include <gtest/gtest.h>
#include <set>

namespace cmpg::test {
namespace {

using Library = shader_double::ShaderLibrary;
constexpr glm::uvec4 kKeys[] = {{1, 2, 3, 4}, {0xdeadbeef, 0x12345678, 0x9abcdef0, 0x0f1e2d3c}, {77, 0x80000000, 5, 0xffffffff}};

// Every elementary interval of 2^t / 2^m area holds 2^t of the 2^m points.
template <class Point> void expectNet(int m, int t, int dimensionX, int dimensionY, const Point& point) {
    for (int bits = 0; bits <= m - t; ++bits) {
        std::vector<int> count(std::size_t(1) << (m - t), 0);
        for (std::uint32_t i = 0; i < 1u << m; ++i) {
            const glm::dvec4 p = point(i);
            ++count[(std::size_t(p[dimensionX] * (1 << bits)) << (m - t - bits)) + std::size_t(p[dimensionY] * (1 << (m - t - bits)))];
        }
        for (const int c : count) ASSERT_EQ(c, 1 << t) << "2^" << m << " points, " << bits << " bits of dimension " << dimensionX;
    }
}

// Quality parameters of the two-dimensional projections of Sobol's first four dimensions: degrees of the polynomials less one, added.
constexpr int kQuality[4][4] = {{0, 0, 1, 2}, {0, 0, 1, 2}, {1, 1, 1, 3}, {2, 2, 3, 2}};

TEST(Sobol, ProjectionsAreNets) {
    Library library;
    for (int m = 4; m <= 12; m += 2) {
        for (int x = 0; x < 4; ++x) {
            for (int y = x + 1; y < 4; ++y) {
                expectNet(m, kQuality[x][y], x, y, [&](std::uint32_t i) { return library.unitInterval(glm::bitfieldReverse(library.sobolDigits(i))); });
                for (const glm::uvec4& key : kKeys) {
                    expectNet(m, kQuality[x][y], x, y, [&](std::uint32_t i) { return library.sobolSet(i, key); });
                    // Later blocks of a pass are nets as well.
                    expectNet(m, kQuality[x][y], x, y, [&](std::uint32_t i) { return library.sobolSet(i + (5u << m), key); });
                }
            }
        }
    }
}

TEST(Sobol, PointsDoNotRepeat) {
    Library library;
    std::set<std::pair<double, double>> seen;
    for (std::uint32_t i = 0; i < 1u << 16; ++i) {
        const glm::dvec4 p = library.sobolSet(i, kKeys[0]);
        ASSERT_TRUE(seen.emplace(p.x, p.y).second) << i;
    }
}

// For a fixed index the scrambled point is uniform over keys: chi-square over 16 x 16 cells of each pair of dimensions.
// 48 cases share a probability of 1 % for a wrong alarm.
TEST(Sobol, EachPointIsUniformOverKeys) {
    Library library;
    for (const std::uint32_t index : {0u, 1u, 2u, 3u, 64u, 1000u, 65535u, 65536u}) {
        for (int x = 0; x < 4; ++x) {
            for (int y = x + 1; y < 4; ++y) {
                std::vector<double> observed(256, 0.0);
                constexpr int kTrials = 1 << 16;
                for (std::uint32_t t = 0; t < kTrials; ++t) {
                    const Library::SampleKey key{glm::uvec2(7, 8), t, index, 0, 2};
                    const glm::dvec4 p = library.sampleSet(key, 1);
                    observed[std::size_t(p[x] * 16) * 16 + std::size_t(p[y] * 16)] += 1;
                }
                EXPECT_GE(chiSquareSignificance(observed, std::vector<double>(256, kTrials / 256.0)), 0.01 / 48) << index << ' ' << x << ' ' << y;
            }
        }
    }
}

// Variance over keys of the mean of n points, and its bias in standard errors.
struct Spread {
    double variance, bias;
};
template <class F> Spread spread(std::uint32_t n, double mean, const F& f) {
    constexpr int kKeysUsed = 2000;
    double sum = 0, squares = 0;
    for (std::uint32_t k = 0; k < kKeysUsed; ++k) {
        double estimate = 0;
        for (std::uint32_t i = 0; i < n; ++i) estimate += f(Library::SampleKey{glm::uvec2(3, 4), k, i, 0, 0}) / n;
        sum += estimate - mean;
        squares += (estimate - mean) * (estimate - mean);
    }
    const double variance = squares / kKeysUsed;
    return {variance, sum / std::sqrt(double(kKeysUsed) * squares + 1e-300)};
}

TEST(Sobol, IntegratesSmoothFunctionsWithLessVariance) {
    Library sobol, independent;
    independent.kSobol = false;
    const auto smooth2 = [](const glm::dvec4& u) { return std::exp(-u.x - 2 * u.y); };
    const auto smooth4 = [](const glm::dvec4& u) { return (1 + (u.x - 0.5)) * (1 + u.y - 0.5) * (1 + u.z - 0.5) * (1 + u.w - 0.5); };
    const double mean2 = (1 - std::exp(-1)) * (1 - std::exp(-2)) / 2;
    const auto ratio = [&](std::uint32_t n, double mean, const auto& f) {
        const Spread a = spread(n, mean, [&](const auto& key) { return f(sobol.sampleSet(key, 0)); });
        const Spread b = spread(n, mean, [&](const auto& key) { return f(independent.sampleSet(key, 0)); });
        EXPECT_LE(std::abs(a.bias), 4); // unbiased over keys: 6e-5 for a wrong alarm
        EXPECT_LE(std::abs(b.bias), 4);
        return a.variance / b.variance;
    };
    // Owen: O(n^-3) against O(1/n) for smooth functions.
    EXPECT_LE(ratio(16, mean2, smooth2), 1.0 / 30);
    EXPECT_LE(ratio(256, mean2, smooth2), 1.0 / 3000);
    EXPECT_LE(ratio(16, 1, smooth4), 1.0 / 4);
    EXPECT_LE(ratio(256, 1, smooth4), 1.0 / 100);
}

// Nested uniform scrambling as it is defined, bit by bit with a strong generator: what the hash imitates.
std::uint32_t trulyNested(Library& library, std::uint32_t x, std::uint32_t bits, std::uint32_t seed) {
    std::uint32_t result = 0;
    for (std::uint32_t b = 0; b < bits; ++b) {
        const std::uint32_t flip = library.hash4(library.hash4(glm::uvec4(x >> (b + 1), b, seed, 1))).x >> 31;
        result |= ((x >> b & 1) ^ flip) << b;
    }
    return result;
}

// One number each from two sets: no correlation, and the variance of the mean product is that of truly nested scrambling
// (1.57 times that of independent pairs, a property of nested shuffles).
TEST(Sobol, SetsAreIndependentOfEachOther) {
    Library library;
    constexpr std::uint32_t kBits = 4, kPoints = 1 << kBits;
    const Spread ours = spread(kPoints, 0, [&](Library::SampleKey key) {
        const double u = library.sampleSet(key, 0).x;
        ++key.bounce;
        return (u - 0.5) * (library.sampleSet(key, 0).x - 0.5);
    });
    const Spread ideal = spread(kPoints, 0, [&](const Library::SampleKey& key) {
        double product = 1;
        for (std::uint32_t set = 0; set < 2; ++set) {
            const std::uint32_t seed = 4 * key.pixel + 2 * set, index = trulyNested(library, key.sampleIndex, kBits, seed);
            product *= trulyNested(library, glm::bitfieldReverse(library.sobolDigits(index)).x >> 8, 24, seed + 1) * 0x1p-24 - 0.5;
        }
        return product;
    });
    EXPECT_LE(std::abs(ours.bias), 4);
    // Each variance comes from 2000 keys: 3.2 %, their ratio 4.5 %.
    EXPECT_NEAR(ours.variance / ideal.variance, 1, 4 * 0.045);
}

} // namespace
} // namespace cmpg::test

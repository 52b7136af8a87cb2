// The shader library as the device runs it, against the same source compiled as C++.
#include "devices.h"

#include "lib/evaluate.h"
#include "lib/relative_error.h"
#include "lib/shader_double.h"
#include "support/evaluate_device.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace cmpg::test {
namespace {

using Library = shader_double::ShaderLibrary;

Query with(Query q, float Query::* member, float value) {
    q.*member = value;
    return q;
}

// The bars of tests/lib/bsdf_values_test.cpp, which the float build meets: 1e-4 of the value, or of the sum of the magnitudes whose
// difference a derivative is. A device may round division and square root a little worse than C++ does; the bars leave room for it.
void compareBsdf(Device& device, double minCosine, double tolerance, double normalTolerance) {
    QueryGenerator generate(29, minCosine);
    std::vector<Query> queries(100'000);
    for (Query& q : queries)
        q = generate();
    const auto results = evaluateOn<BsdfResult>(device, "evaluate_bsdf", queries);
    int lit = 0;
    double worst = 0, worstPdf = 0, worstNormal = 0;
    for (std::size_t i = 0; i < queries.size(); ++i) {
        const Query& q = queries[i];
        const BsdfResult& f = results[i];
        const Evaluation d = evaluateDouble(q);
        const double alpha = std::max(double(q.roughness) * q.roughness, 1e-3);
        const glm::dvec3 metallic = evaluateDouble(with(q, &Query::metallic, 0)).value + evaluateDouble(with(q, &Query::metallic, 1)).value;
        const glm::dvec3 specular = evaluateDouble(with(q, &Query::specular, 0)).value + evaluateDouble(with(q, &Query::specular, 1)).value;
        lit += d.value.x > 0;
        worst = std::max({worst, relativeError(f.value, d.value, d.value), relativeError(f.valueWithDerivatives, d.value, d.value),
                          relativeError(f.baseColor, d.baseColor, d.baseColor), relativeError(f.metallic, d.metallic, metallic),
                          relativeError(f.roughness, d.roughness, d.value * (4.0 * q.roughness / alpha)), relativeError(f.specular, d.specular, specular)});
        worstPdf = std::max(worstPdf, relativeError(glm::dvec3(f.pdf), glm::dvec3(d.pdf), glm::dvec3(d.pdf)));
        for (int c = 0; c < 3; ++c) {
            worstNormal = std::max(worstNormal, relativeError(glm::length(f.normal()[c] - d.normal[c]), glm::length(d.normal[c])));
        }
        ASSERT_TRUE(worst <= tolerance && worstPdf <= tolerance && worstNormal <= normalTolerance)
            << "query " << i << ": value and derivatives " << worst << ", density " << worstPdf << ", normal " << worstNormal;
    }
    EXPECT_GT(lit, 10'000);
    std::printf("largest relative errors: value and derivatives %.2g, density %.2g, by the normal %.2g\n", worst, worstPdf, worstNormal);
}

TEST(DeviceBsdf, AgreesWithDouble) { compareBsdf(device(), 1e-2, 1e-4, 1e-4); }
TEST(DeviceBsdf, AgreesWithDoubleNearGrazing) { compareBsdf(device(), 1e-3, 1e-4, 1e-3); }
TEST(DeviceBsdf, PortableAgreesWithDouble) { compareBsdf(portableDevice(), 1e-2, 1e-4, 1e-4); }

struct LookupQuery { // as in evaluate_lookups.comp
    float number, scale;
    std::uint32_t index;
    glm::uvec4 key;
    glm::vec2 uv;
    std::uint32_t width, height, wrapU, wrapV, nearest;
    glm::vec3 direction;
};

struct LookupResult {
    glm::uvec2 words;
    std::uint32_t fits;
    glm::vec4 sobol;
    glm::uvec4 texels;
    glm::vec4 weights;
    glm::uvec4 environmentTexels;
    glm::vec4 environmentWeights;
    glm::vec2 environmentUv;
    glm::uvec2 cell;
    glm::vec3 cellPoint;
    float sinTheta;
};

class Lookups : public testing::Test {
  protected:
    static constexpr std::size_t kCount = 100'000;
    std::vector<LookupQuery> queries;
    std::vector<LookupResult> results;
    Library library;

    void SetUp() override {
        std::mt19937 random(31);
        const auto uniform = [&] { return double(random()) * 0x1p-32; };
        for (std::size_t i = 0; i < kCount; ++i) {
            LookupQuery q{};
            q.number = float((uniform() - 0.5) * std::pow(10, 40 * uniform() - 20));
            q.scale = std::ldexp(1.0f, int(random() % 60));
            q.index = random();
            q.key = {random(), random(), random(), random()};
            q.uv = {float(6 * uniform() - 3), float(6 * uniform() - 3)};
            q.width = 1 + random() % (i % 2 ? 7 : 2048);
            q.height = 2 + random() % (i % 2 ? 7 : 1024);
            q.wrapU = random() % 3;
            q.wrapV = random() % 3;
            q.nearest = random() % 4 == 0;
            const double z = 2 * uniform() - 1, phi = 2 * std::acos(-1.0) * uniform(), r = std::sqrt(1 - z * z);
            q.direction = glm::vec3(r * std::cos(phi), z, r * std::sin(phi));
            queries.push_back(q);
        }
        const float extremes[] = {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(),
                                  std::numeric_limits<float>::max(), -0.0f, 0.5f, 1.5f, -2.5f};
        for (std::size_t i = 0; i < std::size(extremes); ++i) {
            queries[i].number = extremes[i];
            queries[i].scale = 1;
        }
        results = evaluateOn<LookupResult>(device(), "evaluate_lookups", queries);
    }
};

// The integers of the fixed-point sums and the random numbers are the same bits everywhere.
TEST_F(Lookups, FixedPointIsExact) {
    for (std::size_t i = 0; i < kCount; ++i) {
        const LookupQuery& q = queries[i];
        const double exact = double(q.number) * q.scale;
        const bool fits = std::abs(exact) < 0x1p62;
        ASSERT_EQ(results[i].fits, fits ? 1u : 0u) << q.number << " " << q.scale;
        const std::int64_t expected = fits ? std::int64_t(std::nearbyint(exact)) : std::isnan(exact) ? 0 : std::int64_t(exact > 0 ? 1 : -1) * (std::int64_t(1) << 62);
        ASSERT_EQ(std::int64_t(std::uint64_t(results[i].words.y) << 32 | results[i].words.x), expected) << q.number << " " << q.scale;
    }
}

TEST_F(Lookups, SobolSetsAreExact) {
    for (std::size_t i = 0; i < kCount; ++i)
        ASSERT_EQ(glm::dvec4(results[i].sobol), library.sobolSet(queries[i].index, queries[i].key)) << i;
}

// What a look-up with these texels gives at a texture of random values, in place of comparing indices: at a texel's edge rounding may
// choose the other pair, with the weight that makes it the same value.
double filtered(const glm::uvec4& index, const glm::dvec4& weight) {
    double sum = 0;
    for (int k = 0; k < 4; ++k)
        sum += weight[k] * double(index[k] * 2654435761u) * 0x1p-32;
    return sum;
}

void expectLookup(const glm::uvec4& texels, const glm::vec4& weights, const Library::TexelWeights& expected, const LookupQuery& q, std::size_t& elsewhere) {
    for (int k = 0; k < 4; ++k) {
        ASSERT_LT(texels[k], q.width * q.height);
        ASSERT_GE(weights[k], 0);
    }
    // A coordinate of up to 3 in float, times the size: its rounding in texels.
    const double rounding = 4e-7 * std::max(q.width, q.height) * 4;
    elsewhere += std::abs(filtered(texels, glm::dvec4(weights)) - filtered(expected.index, expected.weight)) > rounding;
}

TEST_F(Lookups, TexelWeights) {
    std::size_t elsewhere = 0, elsewhereInEnvironment = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
        const LookupQuery& q = queries[i];
        const glm::dvec2 uv(q.uv);
        expectLookup(results[i].texels, results[i].weights, library.texelWeights(uv, q.width, q.height, q.wrapU, q.wrapV, q.nearest), q, elsewhere);
        expectLookup(results[i].environmentTexels, results[i].environmentWeights, library.environmentTexelWeights(uv, q.width, q.height), q,
                     elsewhereInEnvironment);
        if (HasFatalFailure())
            return;
    }
    // Nearest texels within rounding of an edge.
    EXPECT_LE(elsewhere, kCount / 2000);
    EXPECT_EQ(elsewhereInEnvironment, 0u);
}

TEST_F(Lookups, EnvironmentCells) {
    std::size_t neighbours = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
        const LookupQuery& q = queries[i];
        const LookupResult& r = results[i];
        const glm::dvec2 uv = library.environmentUv(glm::dvec3(q.direction)), difference = glm::abs(glm::dvec2(r.environmentUv) - uv);
        // Arc tangents of a device are less exact than C++'s: a fiftieth of a texel of a map 2048 wide.
        ASSERT_LE(std::min(difference.x, 1 - difference.x) * std::hypot(q.direction.x, q.direction.z), 1e-5) << i;
        ASSERT_LE(difference.y, 1e-5) << i;
        const glm::vec2 inside = q.uv - glm::floor(q.uv); // exact in float up to its last digit
        const glm::uvec2 cell = library.environmentCell(glm::dvec2(inside), q.width, q.height);
        ASSERT_LT(r.cell.x, q.width);
        ASSERT_LT(r.cell.y, q.height - 1);
        neighbours += r.cell != cell;
        const glm::dvec4 corners = library.environmentCellCorners({double(inside.x), double(inside.y), 1 - double(inside.x), 0});
        const glm::dvec2 point = library.sampleEnvironmentCell(corners, glm::dvec2(inside));
        double sinTheta;
        const glm::dvec3 direction = library.environmentPoint(point.x, r.cell.y, point.y, q.height, sinTheta);
        ASSERT_NEAR(r.sinTheta, sinTheta, 2e-6) << i;
        ASSERT_NEAR(r.cellPoint.y, direction.y, 2e-6) << i;
        ASSERT_LE(glm::length(glm::dvec3(r.cellPoint) - direction), 5e-4) << i; // the 2^-11 Vulkan allows a sine
    }
    EXPECT_LE(neighbours, kCount / 2000); // within rounding of a cell's edge
}

} // namespace
} // namespace cmpg::test

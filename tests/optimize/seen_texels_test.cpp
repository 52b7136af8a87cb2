// The curvature by texels that cameras see: against matrices written out, as a file keeps it, and where it speeds steps up.
#include "linear_model.h"
#include "optimize/gauss_newton.h"
#include "optimize/seen_texels.h"
#include "optimize/texture_curvature.h"
#include "optimize/unseen_texels.h"
#include "scene/texel_lookup.h"

#include <gtest/gtest.h>

#include <numeric>

namespace cmpg::test {
namespace {

constexpr int kWidth = 6, kHeight = 5;

Parameter texture(std::uint32_t channels) { return makeParameter("m.slot", channels == 3 ? SlotKind::BaseColor : SlotKind::Roughness, 7, 4, channels, 0.5f); }

// Rays of six pixels by five: none, one or several, of the texture's material, of another, or of none.
FirstVertices someRays() {
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(-1, 2);
    FirstVertices first;
    first.begin = {0};
    for (int p = 0; p < kWidth * kHeight; ++p) {
        for (int k = int(random() % 5); k > 0; --k)
            first.vertices.push_back({random() % 4 == 0 ? kNoMaterial : std::uint32_t(random() % 3), {uniform(random), uniform(random)}, {}});
        first.begin.push_back(first.vertices.size());
    }
    return first;
}

const std::vector<bool> kOwners{true, false, true};

// Sum over the pixels of k c f^T f, entry by entry; the curvature is the same everywhere, so that its mean over neighbours follows from what they cover.
enum class Parts { Known, All };
std::vector<double> dense(const Parameter& t, const FirstVertices& first, double curvature, Parts parts) {
    const std::size_t n = t.entries(), pixels = kWidth * kHeight;
    std::vector<std::vector<double>> rows(pixels, std::vector<double>(n / t.channels));
    std::vector<double> cover(pixels), pairs(pixels);
    const auto squared = [](const std::vector<double>& a, const std::vector<double>& b) { return std::inner_product(a.begin(), a.end(), b.begin(), 0.0); };
    for (std::size_t p = 0; p < pixels; ++p) {
        const double count = double(first.begin[p + 1] - first.begin[p]);
        std::vector<std::vector<double>> rays;
        for (std::size_t i = first.begin[p]; i < first.begin[p + 1]; ++i) {
            const FirstVertex& ray = first.vertices[i];
            if (ray.material == kNoMaterial || !kOwners[ray.material])
                continue;
            const TexelLookup found = lookUp(t, ray.uv0, ray.uv1);
            rays.emplace_back(n / t.channels);
            for (std::size_t k = 0; k < 4; ++k)
                rays.back()[found.texel[k]] += double(found.weight[k]);
            for (std::size_t k = 0; k < 4; ++k) {
                rows[p][found.texel[k]] += double(found.weight[k]) / count;
                cover[p] += double(found.weight[k]) / count;
            }
        }
        for (std::size_t a = 0; a < rays.size(); ++a)
            for (std::size_t b = 0; b < rays.size(); ++b)
                pairs[p] += a == b ? 0 : squared(rays[a], rays[b]) / (count * (count - 1));
    }
    std::vector<double> matrix(n * n);
    for (int p = 0; p < int(pixels); ++p) {
        if (cover[std::size_t(p)] == 0)
            continue;
        double sum = 0, area = 0, common = 0, all = 0;
        for (int q = 0; q < int(pixels); ++q)
            if (std::abs(q % kWidth - p % kWidth) <= 1 && std::abs(q / kWidth - p / kWidth) <= 1 && cover[std::size_t(q)] > 0) {
                sum += curvature;
                area += cover[std::size_t(q)] * cover[std::size_t(q)];
                common += pairs[std::size_t(q)];
                all += squared(rows[std::size_t(q)], rows[std::size_t(q)]);
            }
        sum *= parts == Parts::Known ? std::clamp(2 * common / all - 1, 0.0, 1.0) : 1;
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = i % t.channels; j < n; j += t.channels)
                matrix[i * n + j] += (t.channels == 1 ? 3 : 1) * sum / area * rows[std::size_t(p)][i / t.channels] * rows[std::size_t(p)][j / t.channels];
    }
    return matrix;
}

TEST(SeenTexels, IsTheMatrixOfWhatPixelsSee) {
    for (const std::uint32_t channels : {1u, 3u}) {
        const Parameter t = texture(channels);
        const FirstVertices first = someRays();
        Image curvature(kWidth, kHeight, 3);
        std::fill(curvature.values.begin(), curvature.values.end(), 2.f);
        SeenTexels seen;
        seen.add(t, kOwners, first, curvature, std::vector<float>(kWidth * kHeight, 0.3f));
        seen.finish();
        ASSERT_TRUE(seen.fits(gridOf(t)) && !seen.empty());
        const std::vector<double> matrix = dense(t, first, 2, Parts::Known), all = dense(t, first, 2, Parts::All);
        EXPECT_NE(matrix, all);
        const std::size_t n = t.entries();
        for (std::size_t j = 0; j < n; ++j) {
            std::vector<float> unit(n), column(n, 1.f);
            unit[j] = 1;
            seen.addMultiply(unit, 0.5f, column);
            double row = 0, told = 0;
            for (std::size_t i = 0; i < n; ++i) {
                EXPECT_NEAR(column[i], 1 + 0.5 * matrix[i * n + j], 1e-5) << i << ", " << j;
                row += matrix[j * n + i];
                told += all[j * n + i];
            }
            EXPECT_NEAR(seen.told()[j], told, 1e-5);
            EXPECT_NEAR(seen.rows()[j], row, 1e-5);
            EXPECT_NEAR(seen.diagonal()[j], matrix[j * n + j], 1e-5);
        }
    }
}

// The left half of a picture sees a bright texel, the right half one that is lit a tenth as much; a third is not in it.
TEST(SeenTexels, LightIsThatOfTheirPixelsOrTheirNoise) {
    constexpr int kColumns = 200;
    Parameter t = makeParameter("m.baseColor", SlotKind::BaseColor, 3, 1, 3, 0.5f);
    t.nearest = true;
    FirstVertices first;
    first.begin = {0};
    Image curvature(kColumns, 1, 3);
    std::vector<float> noise;
    for (int x = 0; x < kColumns; ++x) {
        const bool bright = x < kColumns / 2;
        for (int k = 0; k < 2; ++k)
            first.vertices.push_back({0, {bright ? 0.1f : 0.5f, 0.5f}, {}});
        first.begin.push_back(first.vertices.size());
        for (std::size_t c = 0; c < 3; ++c)
            curvature.values[3 * std::size_t(x) + c] = bright ? 1.f : 0.01f;
        noise.push_back(bright ? 3.f : 1.f);
    }
    const auto light = [&](std::span<const float> ofNoise) {
        SeenTexels seen;
        seen.add(t, {true}, first, curvature, ofNoise);
        seen.finish();
        return std::vector<float>(seen.light().begin(), seen.light().end());
    };
    const std::vector<float> still = light({}), noisy = light(noise);
    EXPECT_NEAR(still[0], 1 / 0.505, 0.03);
    EXPECT_NEAR(still[1], 0.01 / 0.505, 0.03) << "pixels share their curvature at the border";
    EXPECT_EQ(still[2], -1);
    EXPECT_NEAR(noisy[0], 1 / 0.505, 0.03);
    EXPECT_NEAR(noisy[1], 0.5, 0.03) << "dim, but with half of the mean noise";
    EXPECT_EQ(noisy[2], -1);
}

// One view fills what is kept of all: then not all that cameras see is known, and nothing is guessed from it.
TEST(SeenTexels, SaysWhetherAllIsKept) {
    constexpr std::size_t kPixels = SeenTexels::kMostShares / 6; // of up to eight texels each
    FirstVertices first;
    first.begin = {0};
    for (std::size_t p = 0; p < kPixels; ++p) {
        const float u = float(p % 700) / 1024, v = float(p / 700 % 700) / 1024;
        first.vertices.push_back({0, {u, v}, {}});
        first.vertices.push_back({0, {u + 0.2f, v}, {}});
        first.begin.push_back(first.vertices.size());
    }
    const Parameter t = makeParameter("m.slot", SlotKind::Roughness, 64, 64, 1, 0.5f);
    SeenTexels seen;
    Image curvature(int(kPixels), 1, 3, 1.f);
    FirstVertices few;
    few.begin = {first.begin.begin(), first.begin.begin() + 1001};
    few.vertices = {first.vertices.begin(), first.vertices.begin() + 2000};
    seen.add(t, {true}, few, Image(1000, 1, 3, 1.f));
    EXPECT_TRUE(seen.isWhole());
    seen.add(t, {true}, first, curvature);
    EXPECT_FALSE(seen.isWhole());
    seen.finish();
    EXPECT_EQ(expectUnseen(t, seen), nullptr);
    ByteWriter out;
    seen.save(out);
    ByteReader in(out.bytes);
    SeenTexels kept;
    kept.restore(in, t.entries());
    EXPECT_FALSE(kept.isWhole());
}

TEST(SeenTexels, AFileKeepsIt) {
    const Parameter t = texture(3);
    Image curvature(kWidth, kHeight, 3);
    std::fill(curvature.values.begin(), curvature.values.end(), 2.f);
    SeenTexels seen;
    seen.add(t, kOwners, someRays(), curvature);
    seen.finish();
    ByteWriter out;
    seen.save(out);
    SeenTexels again;
    ByteReader in(out.bytes);
    again.restore(in, t.entries());
    std::vector<float> a(t.entries()), b(t.entries()), x(t.entries());
    for (std::size_t i = 0; i < x.size(); ++i)
        x[i] = float(i % 5);
    seen.addMultiply(x, 1, a);
    again.addMultiply(x, 1, b);
    EXPECT_EQ(a, b);
    SeenTexels other;
    ByteReader more(out.bytes);
    EXPECT_THROW(other.restore(more, t.entries() - 3), Malformed);
    std::mt19937 random(5);
    for (int i = 0; i < 2000; ++i) { // read or refused
        std::vector<std::uint8_t> bytes = out.bytes;
        bytes[random() % bytes.size()] = std::uint8_t(random());
        ByteReader damaged(bytes);
        try {
            SeenTexels read;
            read.restore(damaged, t.entries());
            EXPECT_TRUE(read.fits(gridOf(t)));
        } catch (const Malformed&) {
        }
    }
}

// Each pixel sees four texels of a row. With the diagonal alone what tells these apart takes many steps.
TEST(SeenTexels, StepsTellTexelsOfAPixelApart) {
    constexpr std::uint32_t kTexels = 64;
    constexpr int kPixels = 32, kRays = 64;
    const auto rows = [&] { // pixel p sees a window of four texels around 2 p
        FirstVertices first;
        first.begin = {0};
        for (int p = 0; p < kPixels; ++p) {
            for (int k = 0; k < kRays; ++k)
                first.vertices.push_back({0, {(float(2 * p) + 4 * (float(k) + 0.5f) / kRays) / kTexels, 0.5f}, {}});
            first.begin.push_back(first.vertices.size());
        }
        return first;
    }();
    Parameter t = makeParameter("m.specular", SlotKind::Specular, kTexels, 1, 1, 0.5f);
    Image curvature(kPixels, 1, 3);
    std::fill(curvature.values.begin(), curvature.values.end(), 1.f / 3);
    const auto errorAfter = [&](bool known) {
        auto seen = std::make_shared<SeenTexels>();
        seen->add(t, {true}, rows, curvature);
        seen->finish();
        Parameter found = t;
        std::vector<float> truth(kTexels);
        for (std::size_t i = 0; i < kTexels; ++i)
            truth[i] = 0.5f + 0.2f * std::sin(1.3f * float(i)); // a period of about five texels
        Moments moments;
        moments.first.assign(kTexels, 0);
        moments.second.assign(seen->rows().begin(), seen->rows().end());
        if (known)
            moments.seen = seen;
        for (int step = 0; step < 8; ++step) {
            std::vector<float> error(kTexels), gradient(kTexels);
            for (std::size_t i = 0; i < kTexels; ++i)
                error[i] = found.values[i] - truth[i];
            seen->addMultiply(error, 1, gradient);
            const std::vector<double> slope(gradient.begin(), gradient.end());
            updateByGaussNewton(0.04, {slope, std::vector<double>(kTexels)}, TotalVariationBound(found), moments, found);
        }
        std::vector<float> error(kTexels), image(kTexels);
        double loss = 0;
        for (std::size_t i = 0; i < kTexels; ++i)
            error[i] = found.values[i] - truth[i];
        seen->addMultiply(error, 1, image);
        for (std::size_t i = 0; i < kTexels; ++i)
            loss += double(error[i]) * image[i];
        return loss;
    };
    const double diagonal = errorAfter(false), known = errorAfter(true);
    std::cout << "loss after 8 steps: " << diagonal << " by the diagonal, " << known << " where texels are known\n";
    EXPECT_LT(known, 0.2 * diagonal);
}

// Each pixel sees the 64 texels of a row, of which each pass meets four. Steps stay near, whichever four the curvature was measured by.
TEST(SeenTexels, StepsStayNearWhereAPixelSeesManyTexels) {
    constexpr std::uint32_t kTexels = 64, kRows = 16;
    constexpr std::size_t kRays = 4;
    std::mt19937 random(11);
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto rays = [&] {
        FirstVertices first;
        first.begin = {0};
        for (std::uint32_t p = 0; p < kRows; ++p) {
            for (std::size_t k = 0; k < kRays; ++k)
                first.vertices.push_back({0, {uniform(random), (float(p) + 0.5f) / kRows}, {}});
            first.begin.push_back(first.vertices.size());
        }
        return first;
    };
    Parameter found = makeParameter("m.specular", SlotKind::Specular, kTexels, kRows, 1, 0.5f);
    std::vector<double> target(kRows);
    for (double& value : target)
        value = 0.4 + 0.2 * double(uniform(random));
    const auto residual = [&](std::size_t row) {
        return std::accumulate(found.values.begin() + std::ptrdiff_t(row * kTexels), found.values.begin() + std::ptrdiff_t((row + 1) * kTexels), 0.0) / kTexels - target[row];
    };
    const auto loss = [&] {
        double sum = 0;
        for (std::size_t row = 0; row < kRows; ++row)
            sum += residual(row) * residual(row) / kRows;
        return sum;
    };
    // What a pass tells: of each pixel its residual, to the texels that its rays met.
    const auto gradientOf = [&](const FirstVertices& first) {
        std::vector<double> gradient(found.entries());
        for (std::size_t p = 0; p < kRows; ++p)
            for (std::size_t i = first.begin[p]; i < first.begin[p + 1]; ++i) {
                const TexelLookup at = lookUp(found, first.vertices[i].uv0, first.vertices[i].uv1);
                for (std::size_t k = 0; k < 4; ++k)
                    gradient[at.texel[k]] += residual(p) * double(at.weight[k]) / kRays;
            }
        return gradient;
    };
    auto seen = std::make_shared<SeenTexels>();
    Image curvature(1, int(kRows), 3);
    std::fill(curvature.values.begin(), curvature.values.end(), 1.f / 3);
    seen->add(found, {true}, rays(), curvature);
    seen->finish();
    Moments moments;
    moments.first.assign(found.entries(), 0);
    moments.second.assign(seen->told().begin(), seen->told().end());
    moments.seen = seen;
    const double before = loss();
    double largest = 0;
    for (int step = 0; step < 60; ++step) {
        const std::vector<double> a = gradientOf(rays()), b = gradientOf(rays());
        std::vector<double> mean(a.size()), half(a.size());
        for (std::size_t i = 0; i < a.size(); ++i) {
            mean[i] = 0.5 * (a[i] + b[i]);
            half[i] = 0.5 * (a[i] - b[i]);
        }
        updateByGaussNewton(0.04, {mean, half}, TotalVariationBound(found), moments, found);
        if (step >= 10)
            largest = std::max(largest, loss());
    }
    std::cout << "loss " << before << " at first, at most " << largest << " after 10 steps, at last " << loss() << '\n';
    EXPECT_LT(largest, 0.02 * before);
    EXPECT_LT(loss(), 0.01 * before);
}

// Two texels that each pixel sees alike: C has all of their curvature, and none of their difference. Noise takes them no farther apart than four times `stray`.
TEST(SeenTexels, NoiseTakesTexelsOfAPixelApartOnlySoFar) {
    FirstVertices first;
    first.begin = {0};
    for (int p = 0; p < 9; ++p) {
        for (int k = 0; k < 4; ++k)
            first.vertices.push_back({0, {0.5f, 0.5f}, {}}); // between both
        first.begin.push_back(first.vertices.size());
    }
    Parameter t = makeParameter("m.specular", SlotKind::Specular, 2, 1, 1, 0.5f);
    SeenTexels seen;
    Image curvature(3, 3, 3);
    std::fill(curvature.values.begin(), curvature.values.end(), 1.f / 3);
    seen.add(t, {true}, first, curvature);
    seen.finish();
    EXPECT_NEAR(seen.told()[0], seen.rows()[0], 1e-5f); // rays of one point tell the whole row
    constexpr float kDeviation = 0.01f, kStray = 0.02f;
    const TextureCurvature both(TotalVariationBound(t), {&seen, 1}, seen.told(), {kDeviation, kDeviation}, kStray);
    const std::vector<float> step = both.solve({kDeviation, -kDeviation});
    EXPECT_NEAR(step[0], 4 * kStray, 0.01f * kStray);
    EXPECT_NEAR(step[1], -4 * kStray, 0.01f * kStray);
}

} // namespace
} // namespace cmpg::test

// The film's sums of up to 2^32 samples, by the code of the accumulation kernel.
#include "film.h"
#include "render/film.h"
#include "worst.h"

#include <random>
#include <sstream>

namespace cmpg::test {
namespace {

void compare(Worst& mean, Worst& squares, const std::vector<glm::vec3>& block, std::uint64_t samples) {
    const glm::dvec4 got = filmSums(feed(block, samples)) / double(samples);
    glm::dvec4 truth(0);
    glm::dvec3 size(0);
    for (const glm::vec3& v : block) {
        truth += glm::dvec4(glm::dvec3(v), glm::dot(glm::dvec3(v), glm::dvec3(v)) / 3) / double(kFilmBlock);
        size += glm::abs(glm::dvec3(v)) / double(kFilmBlock);
    }
    const auto where = [&] {
        std::ostringstream s;
        s.precision(10);
        s << "samples " << samples << " first " << block[0].x << " mean " << got.x << " truth " << truth.x << " squares " << got.w << " truth " << truth.w;
        return s.str();
    };
    for (int c = 0; c < 3; ++c) mean.compare(got[c], truth[c], where, size[c], 1e-37);
    squares.compare(got.w, truth.w, where, 0, 1e-80);
}

constexpr std::uint64_t kCounts[] = {std::uint64_t(1) << 13, std::uint64_t(1) << 24, std::uint64_t(1) << 26, std::uint64_t(1) << 32};

TEST(ExtremeFilm, Constants) {
    Worst mean("film | mean of a constant | 2^13 to 2^32 samples; radiance 1e-30 to 1e28", "the constant", 1e-6);
    Worst squares("film | mean square of a constant | 2^13 to 2^32 samples; radiance 1e-30 to 1e28", "its square", 1e-6);
    for (const std::uint64_t samples : kCounts)
        for (const float value : {1.0f, 0.1f, 1.0f / 3, 0.7f, 0.99999994f, 1e-30f, 1e-20f, 3e10f, 1e20f, 1e28f, -0.3f})
            compare(mean, squares, std::vector<glm::vec3>(kFilmBlock, value * glm::vec3(1, 0.3f, 0)), samples);
}

TEST(ExtremeFilm, Mixtures) {
    Worst mean("film | mean of rare 1e6 among 1, of both signs | 2^13 to 2^32 samples; scale 1e-20 to 1e20", "float64", 1e-6);
    Worst squares("film | mean square of the same | 2^13 to 2^32 samples; scale 1e-20 to 1e20", "float64", 1e-6);
    std::mt19937 random(11);
    for (const float scale : {1e-20f, 1.0f, 1e20f})
        for (const double negative : {0.0, 0.5}) {
            std::vector<glm::vec3> block(kFilmBlock);
            for (glm::vec3& v : block)
                for (int c = 0; c < 3; ++c) {
                    const float bright = random() % 1000 == 0 ? 1e6f : 1.0f, sign = double(random()) * 0x1p-32 < negative ? -1.0f : 1.0f;
                    v[c] = sign * scale * bright * float(random()) * 0x1p-32f;
                }
            for (const std::uint64_t samples : kCounts) compare(mean, squares, block, samples);
        }
}

TEST(ExtremeFilm, FullEverySample) {
    Worst mean("film | mean of 0.1, every sample added | 2^32 samples", "the constant", 1e-6);
    const double got = filmSums(feedAll(glm::vec3(0.1f), std::uint64_t(1) << 32)).x * 0x1p-32;
    mean.compare(got, 0.1f, [&] { return std::to_string(got); });
}

} // namespace
} // namespace cmpg::test

// The single-precision half of film.h.
#include "film.h"

namespace cmpg::test {
namespace {

using namespace glm;
using gpu::FilmPixel;
using uint = std::uint32_t;
struct Film {
#include "lib/film_sum.glsl"
};

} // namespace

FilmPixel feed(const std::vector<glm::vec3>& block, std::uint64_t samples) {
    Film film;
    FilmPixel p{};
    for (std::uint32_t i = 0; i < kFilmBlock; ++i) film.addSample(p, block[i], i);
    for (std::uint32_t i = 0; i + 1 < kFilmBlock; ++i) film.addSample(p, block[i], kFilmBlock + i);
    const glm::vec4 sum = p.sum, compensation = p.compensation;
    film.addSample(p, block.back(), 2 * kFilmBlock - 1);
    for (std::uint64_t done = 2 * kFilmBlock; done < samples; done += kFilmBlock) {
        p.sum = sum;
        p.compensation = compensation;
        film.addSample(p, block.back(), std::uint32_t(done + kFilmBlock - 1));
    }
    return p;
}

FilmPixel feedAll(const glm::vec3& value, std::uint64_t samples) {
    Film film;
    FilmPixel p{};
    for (std::uint64_t i = 0; i < samples; ++i) film.addSample(p, value, std::uint32_t(i));
    return p;
}

} // namespace cmpg::test

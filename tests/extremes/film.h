// The code of the accumulation kernel on the host, fed with more samples than one could wait for.
#pragma once

#include "shared/film.h"

#include <cstdint>
#include <vector>

namespace cmpg::test {

constexpr std::uint32_t kFilmBlock = 4096;

// Feeds the same block of samples again and again. A block starts from zero, so all but its last sample leave the same sums every time
// and need to be added only twice: once where the scale is still to be found, and once more.
gpu::FilmPixel feed(const std::vector<glm::vec3>& block, std::uint64_t samples);

gpu::FilmPixel feedAll(const glm::vec3& value, std::uint64_t samples);

} // namespace cmpg::test

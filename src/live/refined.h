// A film of a session and how fast it grows.
#pragma once

#include <cmpg/film.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace cmpg {

struct Refined {
    v1::Film film;
    double pathsPerSecond = 0; // 0: not known yet

    // Samples per pixel of the next pass: about a tenth of a second's worth, of which a front end shows every one.
    std::uint32_t nextSamples(std::uint32_t limit) const {
        constexpr double kSeconds = 0.1;
        const double fits = kSeconds * pathsPerSecond / double(film.pixels());
        return std::min(std::uint32_t(std::clamp(fits, 1.0, 4096.0)), limit - film.samples());
    }

    // By how much the edges of a picture made in haste are divided, so that it takes a twentieth of a second. 1: it need not be.
    int previewDivisor() const {
        constexpr double kSeconds = 0.05;
        if (pathsPerSecond == 0)
            return 1;
        const double tooMany = double(film.pixels()) / (kSeconds * pathsPerSecond);
        return tooMany <= 2 ? 1 : int(std::ceil(std::sqrt(tooMany)));
    }
};

} // namespace cmpg

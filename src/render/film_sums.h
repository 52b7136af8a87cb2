// What a pixel's film adds up to.
#pragma once

#include "shared/film.h"

namespace cmpg {

// Sums over its samples of the value, and in w of mean_rgb of the value squared.
inline glm::dvec4 filmSums(const gpu::FilmPixel& p) {
    glm::dvec4 sums = (glm::dvec4(p.total) + glm::dvec4(p.rest)) + (glm::dvec4(p.sum) + glm::dvec4(p.compensation));
    sums.w *= double(p.scale) * double(p.scale);
    return sums;
}

} // namespace cmpg

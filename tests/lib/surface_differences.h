// f |cos| of a surface by differences: as the surface changes, and as its normal turns.
#pragma once

#include "central_difference.h"
#include "shader_double.h"

#include <cmath>
#include <gtest/gtest.h>

namespace cmpg::test {

struct SurfaceDifferences {
    shader_double::ShaderLibrary& library;
    const shader_double::ShaderLibrary::Surface& surface;
    glm::dvec3 n, wo, wi; // unit vectors

    // By h, of what change(surface, h) makes of the surface.
    template <class Change> glm::dvec3 by(Change&& change, double step) const {
        return difference(
            [&](double h) {
                shader_double::ShaderLibrary::Surface changed = surface;
                change(changed, h);
                return library.bsdfCos(changed, n, wo, wi);
            },
            step);
    }

    // Whether the derivatives by the normal, turned towards each axis and renormalised, are those in `d`. `narrow`: the lobe's width or the smaller cosine;
    // `size`: of what is added up, by channel, whose rounding differences have.
    void expectNormal(const shader_double::ShaderLibrary::BsdfDerivatives& d, double narrow, const glm::dvec3& size, double tolerance, int query) const {
        const glm::dvec3* found = &d.at[shader_double::kAtNormal];
        for (int axis = 0; axis < 3; ++axis) {
            glm::dvec3 direction(0);
            direction[axis] = 1;
            const glm::dvec3 finite = difference([&](double h) { return library.bsdfCos(surface, glm::normalize(n + h * direction), wo, wi); }, 2e-3 * narrow);
            for (int c = 0; c < 3; ++c) {
                const double gradient = glm::length(glm::dvec3(found[0][c], found[1][c], found[2][c]));
                EXPECT_NEAR(found[axis][c], finite[c], tolerance * (gradient + size[c] / narrow)) << query << " axis " << axis;
            }
        }
    }
};

} // namespace cmpg::test

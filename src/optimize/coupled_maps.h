// Gauss-Newton steps of several maps of one material together. What its colour, its roughness and its normals do to an image is alike, and a step of one alone goes
// where others should have gone.
#pragma once

#include "optimize/block_curvature.h"
#include "optimize/optimizer.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>

namespace cmpg {

// A pixel p with shares s_pt of the texels t, whose maps change it by a_p, has (sum_t s_pt a_p x_t)^2 <= sum_t s_pt (a_p x_t)^2: the blocks of texels, sum_p s_pt
// a_p a_p^T, bound the curvature as the diagonal of a map alone does (CurvatureDirection), and come from the same passes: what moves one map tells, in the gradient
// by another, what both do together.
struct CoupledMap {
    Parameter& parameter; // of normals one that holds steps (tangent_plane.h)
    Moments& moments;
    const TotalVariationBound& known;
    std::span<const double> gradient, half; // as in NoisyGradient
    double rate;
    float floor = std::numeric_limits<float>::lowest(); // of the values, where it is above the lowest of their range

    float lowest() const { return std::max(parameter.lowest(), floor); }
};

// One update of all, as updateByGaussNewton() has it for one, with blocks in place of D, whose diagonals are the maps' Moments::second, and `cross` off them. Entries
// of a texel keep the direction of their step, however far each of them may go. Those at the end of their range that would leave it are held, and the others step as if they
// were constants. `residual`: what is left of the loss. Images are linear in a map over a part of its range. What a step by as much could not explain tells of none of the maps: the
// residual over the number of texels and the square of that part stands on the diagonals as well (Levenberg 1944). `viewShare`: as in NoisyGradient. `coarser`: along each
// side, so many texels are one of the grid that the last step is on, as of updateByGaussNewton()'s `coarse`.
std::uint64_t updateCoupled(std::span<CoupledMap> maps, const CrossCurvature& cross, double residual, double viewShare, std::size_t coarser = 1);

} // namespace cmpg

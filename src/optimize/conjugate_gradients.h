// The method of conjugate gradients, of systems as large as textures.
#pragma once

#include "optimize/entry_loops.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace cmpg {

// About A^-1 r, with A symmetric and positive. `scaled` = M r, with M the preconditioner. multiply(x, out): out = A x. advance(step, direction, image, x, residual,
// scaled): x += step direction, residual -= step image, scaled = M residual; returns residual . scaled.
template <class Multiply, class Advance>
std::vector<float> conjugateGradients(std::vector<float> residual, std::vector<float> scaled, const Multiply& multiply, const Advance& advance) {
    constexpr std::size_t kMostIterations = 30;   // what is known spreads over so many texels in a step; farther by coarser grids
    constexpr std::size_t kFewestIterations = 10; // of large textures, which would take half of a step otherwise and end as near
    constexpr std::size_t kEntriesOfIterations = std::size_t(1) << 22; // over all of them
    constexpr double kTolerance = 1e-3;           // of the residual's norm
    const auto dot = [](std::span<const float> a, std::span<const float> b) {
        return sumOfEntries(a.size(), [&](std::size_t i) { return double(a[i]) * b[i]; });
    };
    const std::size_t count = residual.size();
    std::vector<float> x(count), direction = scaled, image(count);
    double length = dot(residual, scaled);
    const double enough = length * kTolerance * kTolerance;
    const std::size_t iterations = std::clamp(kEntriesOfIterations / std::max<std::size_t>(1, count), kFewestIterations, kMostIterations);
    for (std::size_t k = 0; k < iterations && length > enough; ++k) {
        multiply(direction, image);
        const double curvature = dot(direction, image);
        if (!(curvature > 0))
            break;
        const double next = advance(float(length / curvature), direction, image, x, residual, scaled);
        const auto turn = float(next / length);
        forEachEntry(count, [&](std::size_t i) { direction[i] = scaled[i] + turn * direction[i]; });
        length = next;
    }
    return x;
}

} // namespace cmpg

// Directions that a surface draws, against the density it states.
#pragma once

#include "evaluate.h"
#include "hemisphere_mesh.h"
#include "statistics.h"

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace cmpg::test {

// Significance of 200 000 directions, in single precision, under the density in double precision: chi square over the cells of the mesh, and one more for what
// is not drawn. `integral`: of the density, at most 1. `sphere`: directions below the hemisphere count in cells of their own, the mirrored ones.
inline double significanceOfDirections(Query q, const HemisphereMesh& mesh, std::uint32_t seed, double& integral, bool sphere = false) {
    const auto density = [&](double side) {
        return mesh.integrate([&](const glm::dvec3& wi) {
            q.wi = glm::vec3(wi.x, wi.y, side * wi.z);
            return evaluateDouble(q).pdf;
        });
    };
    std::vector<double> expected = density(1);
    if (sphere) {
        const std::vector<double> below = density(-1);
        expected.insert(expected.end(), below.begin(), below.end());
    }
    integral = std::accumulate(expected.begin(), expected.end(), 0.0);
    constexpr int kSamples = 200000;
    std::mt19937 random(seed);
    const auto number = [&] { return float(random() >> 8) * 0x1p-24f; };
    std::vector<double> observed(expected.size() + 1, 0.0);
    for (int i = 0; i < kSamples; ++i) {
        const float x = number(), y = number(), z = number();
        glm::vec3 wi;
        const bool drawn = sampleFloat(q, {x, y, z}, wi), below = sphere && wi.z < 0;
        if (below)
            wi.z = -wi.z;
        observed[drawn ? mesh.cellOf(wi) + (below ? mesh.cells() : 0) : expected.size()] += 1;
    }
    expected.push_back(std::max(1 - integral, 0.0));
    for (double& e : expected)
        e *= kSamples;
    return chiSquareSignificance(observed, expected);
}

} // namespace cmpg::test

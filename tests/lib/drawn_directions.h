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
// is not drawn. `integral`: of the density, at most 1.
inline double significanceOfDirections(Query q, const HemisphereMesh& mesh, std::uint32_t seed, double& integral) {
    std::vector<double> expected = mesh.integrate([&](const glm::dvec3& wi) {
        q.wi = glm::vec3(wi);
        return evaluateDouble(q).pdf;
    });
    integral = std::accumulate(expected.begin(), expected.end(), 0.0);
    constexpr int kSamples = 200000;
    std::mt19937 random(seed);
    const auto number = [&] { return float(random() >> 8) * 0x1p-24f; };
    std::vector<double> observed(mesh.cells() + 1, 0.0);
    for (int i = 0; i < kSamples; ++i) {
        const float x = number(), y = number(), z = number();
        glm::vec3 wi;
        observed[sampleFloat(q, {x, y, z}, wi) ? mesh.cellOf(wi) : mesh.cells()] += 1;
    }
    expected.push_back(std::max(1 - integral, 0.0));
    for (double& e : expected)
        e *= kSamples;
    return chiSquareSignificance(observed, expected);
}

} // namespace cmpg::test

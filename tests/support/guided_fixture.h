// A renderer with a guide, a fixed adjoint and fixed directions in parameter space; trees that mislead.
#pragma once

#include "guiding/field/quadtree.h"
#include "support/render_fixture.h"

#include <numeric>

namespace cmpg::test {

inline RenderConfig guidedConfig(std::uint32_t depth = 5) {
    RenderConfig config;
    config.guiding = true;
    config.maxDepth = depth;
    config.guide.cellRecords = 400; // tiny passes, still many cells
    return config;
}

struct GuidedBench : Bench {
    View view;
    Image adjoint;
    std::vector<std::vector<float>> directions;

    GuidedBench(const std::string& name, const std::vector<std::string>& globs, int edge, const RenderConfig& c = guidedConfig(), Device& on = device())
        : Bench(bundledScene(name), globs, c, on), view(viewOf(scene, edge, edge)), adjoint(edge, edge, 3), directions(ones()) {
        // Positive, so that sums stand out from their noise; uneven, so that nothing cancels by symmetry.
        std::mt19937 random(12);
        std::uniform_real_distribution<float> uniform(0.5f, 1.5f);
        for (float& a : adjoint.values)
            a = uniform(random);
        for (auto& direction : directions)
            for (float& d : direction)
                d = uniform(random);
    }

    // Learning passes by the material alone. Returns the roulette's reference.
    double train(std::uint32_t passes, std::uint32_t spp) {
        std::vector<std::vector<double>> ignored;
        double reference = 0;
        for (std::uint32_t i = 0; i < passes; ++i) {
            reference = renderer->reverse(view, spp, {77, i, 3}, adjoint, {}, {}, ignored, {.record = true}).reference;
            renderer->updateGuide();
        }
        plan = {};
        return reference;
    }

    std::vector<std::vector<double>> gradient(std::uint32_t spp, const PassKey& key) {
        std::vector<std::vector<double>> g;
        result = renderer->reverse(view, spp, key, adjoint, {}, {}, g, plan);
        return g;
    }
    // The gradient along the directions.
    double along(const std::vector<std::vector<double>>& g, std::size_t i) const {
        return std::inner_product(g[i].begin(), g[i].end(), directions[i].begin(), 0.0);
    }
};

// Trees over the cells of another; all but the first know something wrong everywhere.
enum class Misleading { Nothing, OneBin, BelowTheHorizon, Poles, DerivativesOnly, Spike };

// Adds mass to the leaf `depth` levels down at a point of the square.
inline void addMass(std::vector<QuadNode>& nodes, glm::dvec2 at, std::uint32_t depth, const GuideMass& mass) {
    std::uint32_t node = 0;
    for (std::uint32_t level = 1;; ++level) {
        at *= 2.0;
        const std::uint32_t q = std::uint32_t(at.x >= 1) + 2 * std::uint32_t(at.y >= 1);
        at -= glm::floor(at);
        if (level == depth) {
            nodes[node].mass[q] += mass;
            return;
        }
        if (!nodes[node].child[q]) {
            nodes[node].child[q] = std::uint32_t(nodes.size());
            nodes.push_back({});
        }
        node = nodes[node].child[q];
    }
}

inline SdTree misleading(SdTree tree, Misleading how) {
    for (GuideCell& cell : tree.cells()) {
        cell.nodes.assign(1, {});
        cell.records = 1;
        cell.reflected = cell.derivative = 0;
        switch (how) {
        case Misleading::Nothing:
            break;
        case Misleading::OneBin: // 1e-6 of the sphere
            addMass(cell.nodes, {0.7, 0.3}, 10, {1, 1, 1});
            break;
        case Misleading::BelowTheHorizon: // y < 0
            cell.nodes[0].mass[1] = cell.nodes[0].mass[3] = {1, 2, 3};
            break;
        case Misleading::Poles:
            addMass(cell.nodes, {0.3, 0.9999}, 10, {1, 0, 1});
            addMass(cell.nodes, {0.0, 0.0}, 10, {2, 1, 0});
            break;
        case Misleading::DerivativesOnly:
            addMass(cell.nodes, {0.2, 0.4}, 2, {0, 1, 0});
            addMass(cell.nodes, {0.7, 0.7}, 1, {0, 0, 1e-3});
            break;
        case Misleading::Spike: // on top of next to nothing
            for (GuideMass& m : cell.nodes[0].mass)
                m = {1e-12, 1e-12, 1e-12};
            addMass(cell.nodes, {0.3, 0.6}, 9, {1e12, 1e12, 1e-12});
            break;
        }
        sumUp(cell.nodes);
    }
    return tree;
}

// Joint standard errors that two means of normal estimates differ by with the probability of four standard deviations, 6e-5: Student's t
// by its expansion about the normal distribution (Abramowitz and Stegun 26.7.5), with Welch's degrees of freedom.
inline double fourDeviations(const MeanError& a, const MeanError& b) {
    const double va = a.standardError * a.standardError, vb = b.standardError * b.standardError;
    const double freedom = (va + vb) * (va + vb) / std::max(va * va / double(a.estimates - 1) + vb * vb / double(b.estimates - 1), 1e-300);
    constexpr double z = 4, z3 = z * z * z, z5 = z3 * z * z;
    return z + (z3 + z) / (4 * freedom) + (5 * z5 + 16 * z3 + 3 * z) / (96 * freedom * freedom);
}

// Equal with a confidence of 1 - 6e-5 each.
inline void expectAgreement(const MeanError& a, const MeanError& b, const std::string& what) {
    const double allowed = a.standardError + b.standardError > 0 ? fourDeviations(a, b) : 4;
    EXPECT_LE(std::abs(a.mean - b.mean), allowed * std::hypot(a.standardError, b.standardError) + 1e-6 * std::abs(a.mean))
        << what << ": " << a.mean << " +- " << a.standardError << " against " << b.mean << " +- " << b.standardError;
}

} // namespace cmpg::test

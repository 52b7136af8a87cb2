// Records as a pass would leave them, made up: samples of position, direction and value, placed into a guide's cells.
#pragma once

#include "guiding/field/sd_tree.h"

#include <random>

namespace cmpg {

struct Sample {
    glm::vec3 position{};
    glm::dvec2 square{}; // of the direction, in [0, 1)
    GuideMass mass;
    double reflected = 0, derivative = 0;
};

// One CellRecords per cell that a sample falls into, in the order of the cells.
inline std::vector<CellRecords> place(const SdTree& tree, const std::vector<Sample>& samples) {
    std::vector<CellRecords> all(tree.cells().size());
    for (const Sample& sample : samples) {
        const std::uint32_t cell = tree.cellAt(sample.position);
        const std::vector<QuadNode>& nodes = tree.cells()[cell].nodes;
        CellRecords& r = all[cell];
        r.cell = cell;
        r.leaves.resize(nodes.size());
        ++r.count;
        r.reflected += sample.reflected;
        r.derivative += sample.derivative;
        glm::dvec2 p = sample.square;
        for (std::uint32_t node = 0;;) {
            const glm::dvec2 doubled = 2.0 * p;
            const std::uint32_t q = std::uint32_t(doubled.x >= 1) + 2 * std::uint32_t(doubled.y >= 1);
            p = doubled - glm::floor(doubled);
            if (!nodes[node].child[q]) {
                r.leaves[node][q] += sample.mass;
                break;
            }
            node = nodes[node].child[q];
        }
    }
    std::erase_if(all, [](const CellRecords& r) { return r.count == 0; });
    return all;
}

// Half of the samples in clusters, half anywhere in the box; directions likewise. Values are multiples of 1/16 below 64, so that sums
// of fewer than 2^43 of them are exact in any order; three quarters have no derivative.
inline std::vector<Sample> randomSamples(glm::vec3 lower, glm::vec3 upper, std::size_t count, std::uint32_t seed) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return double(random()) * 0x1p-32; };
    const auto value = [&] { return double(random() % 1024) / 16; };
    const glm::dvec3 cluster(uniform(), uniform(), uniform());
    const glm::dvec2 lobe(uniform(), uniform());
    std::vector<Sample> samples(count);
    for (Sample& s : samples) {
        const double width = random() % 2 ? 0.02 : 1;
        const double spread = random() % 2 ? 0.01 : 1;
        glm::dvec3 u(uniform(), uniform(), uniform());
        u = glm::fract(cluster + width * u);
        s.position = lower + glm::vec3(u) * (upper - lower);
        s.square = glm::fract(lobe + spread * glm::dvec2(uniform(), uniform()));
        s.mass.primal = value();
        if (random() % 4 == 0)
            (random() % 2 ? s.mass.plus : s.mass.minus) = value();
        s.reflected = value();
        s.derivative = value();
    }
    return samples;
}

// Sums over all cells.
struct TreeTotals {
    GuideMass mass;
    double records = 0, reflected = 0, derivative = 0;
};
inline TreeTotals totals(const SdTree& tree) {
    TreeTotals t;
    for (const GuideCell& cell : tree.cells()) {
        t.mass += cell.total() * cell.faded;
        t.records += cell.weight();
        t.reflected += cell.reflected * cell.faded;
        t.derivative += cell.derivative * cell.faded;
    }
    return t;
}

// Equal to the last bit.
inline bool same(const GuideMass& a, const GuideMass& b) { return a.primal == b.primal && a.plus == b.plus && a.minus == b.minus; }
inline bool same(const SdTree& a, const SdTree& b) {
    if (a.lower() != b.lower() || a.upper() != b.upper() || a.updates() != b.updates() || a.spatial().size() != b.spatial().size() ||
        a.cells().size() != b.cells().size())
        return false;
    for (std::size_t i = 0; i < a.spatial().size(); ++i)
        if (a.spatial()[i].child != b.spatial()[i].child || a.spatial()[i].cell != b.spatial()[i].cell)
            return false;
    for (std::size_t i = 0; i < a.cells().size(); ++i) {
        const GuideCell &x = a.cells()[i], &y = b.cells()[i];
        if (x.records != y.records || x.faded != y.faded || x.reflected != y.reflected || x.derivative != y.derivative || x.changed != y.changed ||
            x.nodes.size() != y.nodes.size())
            return false;
        for (std::size_t n = 0; n < x.nodes.size(); ++n)
            for (std::uint32_t q = 0; q < 4; ++q)
                if (!same(x.nodes[n].mass[q], y.nodes[n].mass[q]) || x.nodes[n].child[q] != y.nodes[n].child[q])
                    return false;
    }
    return true;
}

} // namespace cmpg

// What a guide holds, in numbers.
#include "library/guide_statistics.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

// Calls leaf(mass, depth) for every quadrant without children; the root's quadrants have depth 1.
template <class F> void visitLeaves(const std::vector<QuadNode>& nodes, const F& leaf, std::uint32_t node = 0, std::uint32_t depth = 1) {
    for (std::uint32_t q = 0; q < 4; ++q)
        if (nodes[node].child[q])
            visitLeaves(nodes, leaf, nodes[node].child[q], depth + 1);
        else
            leaf(nodes[node].mass[q], depth);
}

std::array<double, 3> parts(const GuideMass& mass) { return {mass.primal, mass.plus, mass.minus}; }
std::array<double, 3> coordinates(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

bool knowsDerivatives(const GuideCellFigures& cell) { return cell.means[1] > 0 || cell.means[2] > 0; }

} // namespace

std::vector<GuideCellFigures> cellFigures(const SdTree& tree) {
    std::vector<GuideCellFigures> cells(tree.cells().size());
    const auto visit = [&](const auto& self, std::uint32_t node, glm::dvec3 lower, glm::dvec3 upper, std::uint32_t depth) -> void {
        const SpatialNode& n = tree.spatial()[node];
        if (n.child) {
            const int axis = int(depth % 3);
            glm::dvec3 end = upper, begin = lower;
            end[axis] = begin[axis] = (lower[axis] + upper[axis]) / 2;
            self(self, n.child, lower, end, depth + 1);
            self(self, n.child + 1, begin, upper, depth + 1);
            return;
        }
        const GuideCell& cell = tree.cells()[n.cell];
        GuideCellFigures& figures = cells[n.cell];
        figures = {.lower = coordinates(lower), .upper = coordinates(upper), .depth = depth, .nodes = cell.nodes.size(), .records = cell.weight()};
        visitLeaves(cell.nodes, [&](const GuideMass&, std::uint32_t level) { figures.quadDepth = std::max(figures.quadDepth, level); });
        if (cell.records > 0) {
            figures.means = parts(cell.total() * (1 / cell.records));
            figures.reflected = cell.reflected / cell.records;
            figures.derivative = cell.derivative / cell.records;
        }
    };
    visit(visit, 0, tree.lower(), tree.upper(), 0);
    return cells;
}

GuideFigures figuresOf(const SdTree& tree, const std::vector<GuideCellFigures>& cells) {
    GuideFigures f;
    f.lower = coordinates(tree.lower());
    f.upper = coordinates(tree.upper());
    f.cells = cells.size();
    f.mostNodes = tree.config().maxNodes;
    f.updates = tree.updates();
    f.forgetting = tree.config().forgetting;
    GuideMass mass;
    double spatialSum = 0, quadSum = 0;
    std::uint64_t leaves = 0;
    std::size_t empty = 0, blind = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const GuideCellFigures& cell = cells[i];
        f.nodes += cell.nodes;
        f.spatialDepth = std::max(f.spatialDepth, cell.depth);
        f.quadDepth = std::max(f.quadDepth, cell.quadDepth);
        spatialSum += cell.depth;
        visitLeaves(tree.cells()[i].nodes, [&](const GuideMass&, std::uint32_t level) {
            quadSum += level;
            ++leaves;
        });
        f.records += cell.records;
        mass += tree.cells()[i].total() * tree.cells()[i].faded;
        empty += cell.records == 0;
        blind += !knowsDerivatives(cell);
        if (cell.records > cells[f.mostRecords].records)
            f.mostRecords = std::uint32_t(i);
    }
    f.mass = parts(mass);
    f.meanSpatialDepth = spatialSum / double(f.cells);
    f.meanQuadDepth = quadSum / double(leaves);
    f.withoutRecords = double(empty) / double(f.cells);
    f.withoutDerivative = double(blind) / double(f.cells);
    return f;
}

std::string validateDensities(const SdTree& tree) {
    for (std::size_t i = 0; i < tree.cells().size(); ++i) {
        const GuideCell& cell = tree.cells()[i];
        if (cell.records == 0)
            continue;
        for (const auto member : {&GuideMass::primal, &GuideMass::plus, &GuideMass::minus}) {
            const auto mean = [&](const GuideMass& m) { return float(m.*member / cell.records); };
            const float all = mean(cell.total());
            if (all == 0)
                continue; // such a cell draws nothing
            double integral = 0;
            visitLeaves(cell.nodes, [&](const GuideMass& m, std::uint32_t) { integral += double(mean(m)) / double(all); });
            if (std::abs(integral - 1) > 1e-4)
                return "cell " + std::to_string(i) + " has a density whose integral is " + std::to_string(integral);
        }
    }
    return {};
}

} // namespace cmpg

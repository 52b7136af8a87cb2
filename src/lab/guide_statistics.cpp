// What a guide holds, in numbers.
#include "lab/guide_statistics.h"

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

bool knowsDerivatives(const GuideCellFigures& cell) { return cell.mean.plus > 0 || cell.mean.minus > 0; }

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
        figures = {lower, upper, depth, 0, cell.nodes.size(), cell.weight(), {}, 0, 0};
        visitLeaves(cell.nodes, [&](const GuideMass&, std::uint32_t level) { figures.quadDepth = std::max(figures.quadDepth, level); });
        if (cell.records > 0) {
            figures.mean = cell.total() * (1 / cell.records);
            figures.reflected = cell.reflected / cell.records;
            figures.derivative = cell.derivative / cell.records;
        }
    };
    visit(visit, 0, tree.lower(), tree.upper(), 0);
    return cells;
}

GuideFigures figuresOf(const SdTree& tree, const std::vector<GuideCellFigures>& cells) {
    GuideFigures f;
    f.cells = cells.size();
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
        f.mass += tree.cells()[i].total() * tree.cells()[i].faded;
        empty += cell.records == 0;
        blind += !knowsDerivatives(cell);
        if (cell.records > cells[f.mostRecords].records)
            f.mostRecords = std::uint32_t(i);
    }
    f.meanSpatialDepth = spatialSum / double(f.cells);
    f.meanQuadDepth = quadSum / double(leaves);
    f.withoutRecords = double(empty) / double(f.cells);
    f.withoutDerivative = double(blind) / double(f.cells);
    return f;
}

std::string cellTable(const std::vector<GuideCellFigures>& cells) {
    std::string table = "cell,depth,records,nodes,quad_depth,primal,plus,minus,reflected,derivative,"
                        "lower_x,lower_y,lower_z,upper_x,upper_y,upper_z\n";
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const GuideCellFigures& c = cells[i];
        char line[400];
        std::snprintf(line, sizeof line, "%zu,%u,%.9g,%llu,%u,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", i, c.depth,
                      c.records, static_cast<unsigned long long>(c.nodes), c.quadDepth, c.mean.primal, c.mean.plus, c.mean.minus,
                      c.reflected, c.derivative, c.lower.x, c.lower.y, c.lower.z, c.upper.x, c.upper.y, c.upper.z);
        table += line;
    }
    return table;
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

// What a guide holds, in numbers.
#pragma once

#include "guiding/field/sd_tree.h"

#include <string>

namespace cmpg {

// Of one cell. Means are per record.
struct GuideCellFigures {
    glm::dvec3 lower{}, upper{}; // its box
    std::uint32_t depth = 0;     // spatial levels above it
    std::uint32_t quadDepth = 0; // levels of its quadtree
    std::uint64_t nodes = 0;
    double records = 0;
    GuideMass mean;
    double reflected = 0, derivative = 0; // means
};

std::vector<GuideCellFigures> cellFigures(const SdTree& tree); // by number

struct GuideFigures {
    std::size_t cells = 0;
    std::uint64_t nodes = 0;
    std::uint32_t spatialDepth = 0, quadDepth = 0;    // greatest
    double meanSpatialDepth = 0, meanQuadDepth = 0;   // over cells; over all leaves of their quadtrees
    double records = 0;                               // statistical weight: less than was recorded, as it fades
    GuideMass mass;                                   // sums over cells
    double withoutRecords = 0, withoutDerivative = 0; // shares of the cells
    std::uint32_t mostRecords = 0;                    // number of the cell that has them
};

GuideFigures figuresOf(const SdTree& tree, const std::vector<GuideCellFigures>& cells);

// One line per cell under a line of names.
std::string cellTable(const std::vector<GuideCellFigures>& cells);

// What must hold beyond SdTree::validate(): densities integrate to 1 within 1e-4 with the single-precision means that the device
// reads. Empty, or what is wrong.
std::string validateDensities(const SdTree& tree);

} // namespace cmpg

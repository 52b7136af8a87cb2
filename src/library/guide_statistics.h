// What a guide holds, in numbers.
#pragma once

#include "guiding/field/sd_tree.h"

#include <cmpg/guide.h>

namespace cmpg {

std::vector<GuideCellFigures> cellFigures(const SdTree& tree); // by number

// Without what only the guide's file says.
GuideFigures figuresOf(const SdTree& tree, const std::vector<GuideCellFigures>& cells);

// What must hold beyond SdTree::validate(): densities integrate to 1 within 1e-4 with the single-precision means that the device
// reads. Empty, or what is wrong.
std::string validateDensities(const SdTree& tree);

} // namespace cmpg

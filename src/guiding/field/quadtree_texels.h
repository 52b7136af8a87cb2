// Quadtree nodes as kernels read them.
#pragma once

#include "guiding/field/sd_tree.h"

namespace cmpg {

// One node: see shared/guide.h. `first`: where the nodes of its cell begin. Fractions are within 1 / kQuadFractionOne of the masses', and 0
// or 1 only where a side has no mass, so what has mass is drawn and what has none is not. Kernels take densities from the same
// fractions: rounding them moves no expectation.
glm::uvec4 quadtreeTexel(const QuadNode& node, std::uint32_t first);

} // namespace cmpg

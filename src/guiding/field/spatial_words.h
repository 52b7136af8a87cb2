// The spatial tree as kernels read it.
#pragma once

#include "guiding/field/sd_tree.h"

namespace cmpg {

// Three levels of the binary tree, one of each axis, become one node of eight words: see shared/guide.h. A leaf above the third level is in all
// words of its part. At most eight words a cell.
std::vector<std::uint32_t> spatialWords(std::span<const SpatialNode> tree);

} // namespace cmpg

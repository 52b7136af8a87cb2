// From two children a node to eight.
#include "guiding/field/spatial_words.h"

#include "shared/guide.h"

namespace cmpg {

std::vector<std::uint32_t> spatialWords(std::span<const SpatialNode> tree) {
    std::vector<std::uint32_t> roots{0}; // in the binary tree, of the nodes so far: breadth first, so that those near the root lie together
    std::vector<std::uint32_t> words;
    for (std::size_t i = 0; i < roots.size(); ++i)
        for (std::uint32_t octant = 0; octant < gpu::kSpatialChildren; ++octant) {
            std::uint32_t node = roots[i];
            for (int axis = 0; axis < 3 && tree[node].child; ++axis)
                node = tree[node].child + (octant >> axis & 1);
            if (tree[node].child) {
                words.push_back(gpu::kSpatialChildren * std::uint32_t(roots.size()));
                roots.push_back(node);
            } else {
                words.push_back(gpu::kSpatialLeaf | tree[node].cell);
            }
        }
    return words;
}

} // namespace cmpg

// Splits triangles into a binary tree by the binned surface-area heuristic, on several threads.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <vector>

namespace cmpg {

struct Box {
    glm::vec3 low{std::numeric_limits<float>::infinity()};
    glm::vec3 high{-std::numeric_limits<float>::infinity()};

    void grow(const Box& b) {
        low = glm::min(low, b.low);
        high = glm::max(high, b.high);
    }
    void grow(glm::vec3 p) {
        low = glm::min(low, p);
        high = glm::max(high, p);
    }
    // Half the surface, the probability (up to a factor) that a random line meets the box.
    float halfArea() const {
        const glm::vec3 e = high - low;
        return e.x < 0 ? 0.f : e.x * e.y + e.y * e.z + e.z * e.x;
    }
};

// A thing to be placed in the tree; `item` is what it stands for, `triangles` how many it holds.
struct Reference {
    glm::vec3 low;
    std::uint32_t item;
    glm::vec3 high;
    std::uint32_t triangles;
};

// An inner node over references [begin, end): its children are [begin, middle) and [middle, end). Of a node in slot s the left child
// stands in slot s + 1, the right child in slot s + (middle - begin). So every subtree owns its slots, and threads need not agree
// on anything.
struct SplitNode {
    Box left, right;
    std::uint32_t middle;
    bool leftLeaf, rightLeaf;
};

struct SplitTree {
    std::vector<SplitNode> slots; // slot 0 is the root; unused slots in between
    Box box;
    bool single = true; // all references form one leaf, there is no node
};

// Reorders `references`. The result is the same for every thread count.
SplitTree splitReferences(std::vector<Reference>& references, unsigned threads);

} // namespace cmpg

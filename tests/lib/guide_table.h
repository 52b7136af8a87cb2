// A guide as the kernels read it, in a test's own memory, and trees to fill it with. Kept apart from files compiled with other constants.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

namespace cmpg::test {

struct GuideTable {
    struct Cell {
        std::uint32_t root = 0;
        glm::vec3 total{}; // means of P, D+, D-
    };
    glm::vec3 lower{}, inverseExtent{};
    std::vector<std::uint32_t> spatial;            // words as in shared/guide.h
    std::vector<Cell> cells;
    std::vector<glm::uvec4> nodes;                 // as there
    std::vector<glm::dvec3> masses;                // what nodes are made from: P, D+, D-, four a node
    std::vector<std::uint32_t> children;           // likewise; 0: none
    std::function<std::uint32_t(glm::vec3)> cellAt; // the host's own look-up
};

// A tree of the box from (-1, -2, 0.5) to (1, 2, 1.5) that grew over `updates` passes of random records; none: it knows nothing.
GuideTable grownTable(std::uint32_t updates, std::uint32_t seed);

// One cell with a random quadtree, up to ten levels deep along a random path. Masses of P, D+ and D- go from 10^-spread to 10^spread;
// those of which the bit is set in `absent` are zero.
GuideTable randomTable(std::uint32_t seed, double spread, std::uint32_t absent);

// chiSquareSignificance() of statistics.h.
double significance(const std::vector<double>& observed, const std::vector<double>& expected);

} // namespace cmpg::test

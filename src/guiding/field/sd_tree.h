// The guide on the host: a binary tree over the scene's box whose leaves, the cells, hold a quadtree over directions each.
// Müller, Gross, Novák 2017, "Practical Path Guiding for Efficient Light-Transport Simulation"; three masses in one topology after
// Fan et al. 2024, "Conditional Mixture Path Guiding for Differentiable Rendering".
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

// What one part of the sphere returned: sums over records of mean_rgb of reflected light (primal) and of the positive and negative
// terms of its derivative (plus, minus; both >= 0).
struct GuideMass {
    double primal = 0, plus = 0, minus = 0;
    GuideMass& operator+=(const GuideMass& o) {
        primal += o.primal;
        plus += o.plus;
        minus += o.minus;
        return *this;
    }
    GuideMass operator*(double f) const { return {primal * f, plus * f, minus * f}; }
};

// Four quadrants of a square, number (x >= middle) + 2 (y >= middle). Square: x = azimuth / 2 pi, y = (1 + z) / 2, in world space.
struct QuadNode {
    std::array<GuideMass, 4> mass{};         // of inner quadrants: the sum over their children
    // Index among the cell's nodes; 0: a leaf (the root, 0, is nobody's child). Those of a node lie side by side, in this order.
    std::array<std::uint32_t, 4> child{};
};

struct GuideCell {
    std::vector<QuadNode> nodes; // [0] is the root; at least one
    double records = 0;          // statistical weight of the sums: means are sums / records
    double faded = 1;            // factor on the weight and all sums, applied when the cell learns again: until then its means are the same bits
    // Sums of mean_rgb R_i and of the L1 norm of T_i over all vertices, light sampling included.
    double reflected = 0, derivative = 0;
    bool changed = true; // since the last publication: means differ
    GuideMass total() const;
    double weight() const { return records * faded; } // against other cells
};

// Split at the middle; the axis cycles x, y, z with the depth.
struct SpatialNode {
    std::uint32_t child = 0; // of the first of two neighbours; 0: a leaf
    std::uint32_t cell = 0;  // of a leaf
};

struct SdTreeConfig {
    std::uint32_t cellRecords = 6000;        // a cell that got more new records splits
    double directionShare = 0.03;            // a quadrant with a larger share of any mass of its cell splits, others collapse
    double forgetting = 0.9;                 // factor on old sums and weights in every update that forgets
    std::uint32_t maxQuadDepth = 10;         // levels below the root's square
    std::uint32_t maxSpatialDepth = 40;
    std::uint64_t maxNodes = 1u << 18;       // quadtree nodes over all cells; splits stop there
};

// New records of one cell, laid out as its nodes are.
struct CellRecords {
    std::uint32_t cell = 0;
    std::uint64_t count = 0;
    double reflected = 0, derivative = 0;
    std::vector<std::array<GuideMass, 4>> leaves; // one per node; entries of inner quadrants are ignored
};

struct UpdateReport {
    std::uint64_t records = 0;
    std::uint32_t spatialSplits = 0;
    std::uint64_t refusedSplits = 0; // for want of nodes: what the limit cost
};

class SdTree {
  public:
    static constexpr std::uint32_t kScoutDepth = 12;     // spatial levels of a tree that knows nothing yet
    static constexpr std::uint32_t kScoutQuadDepth = 3;  // levels of its quadtrees: 8 x 8 leaves

    static constexpr double kMaxMean = 1e30;             // of a cell: more is an error and would overflow on the device

    // A tree that knows nothing: a regular grid of cells with regular quadtrees, all masses 0 (less deep where maxNodes demands it).
    // The first update keeps as much of it as its records justify: a subtree that got at most cellRecords becomes one cell.
    SdTree(glm::vec3 lower, glm::vec3 upper, const SdTreeConfig& config);

    // Fits the tree to new records, in this order: forgets (`forget`: what the old ones were made for has changed), adds, splits cells by their new
    // records (both halves get half of sums and weight, again until no half has too many), refines and collapses quadtrees. Same result for any
    // number of threads. `records` may come in any order, each cell at most once.
    UpdateReport update(std::span<const CellRecords> records, bool forget = true);

    bool empty() const { return updates_ == 0; }
    std::uint32_t updates() const { return updates_; }
    glm::vec3 lower() const { return lower_; }
    glm::vec3 upper() const { return upper_; }
    const SdTreeConfig& config() const { return config_; }
    const std::vector<SpatialNode>& spatial() const { return spatial_; } // [0] is the root
    const std::vector<GuideCell>& cells() const { return cells_; }
    std::vector<GuideCell>& cells() { return cells_; } // to mark what was published
    std::uint64_t nodes() const;                       // over all cells
    void limitNodes(std::uint64_t most);               // from now on; never below what there is
    std::uint32_t cellAt(glm::vec3 position) const;    // positions outside the box count as on its faces

    // Everything that must hold: indices in range and used once, sums consistent, finite and >= 0. Empty, or what is wrong.
    std::string validate() const;

  private:
    friend class GuideFile;
    glm::vec3 lower_, upper_;
    SdTreeConfig config_;
    std::vector<SpatialNode> spatial_;
    std::vector<GuideCell> cells_;
    std::uint32_t updates_ = 0;
};

} // namespace cmpg

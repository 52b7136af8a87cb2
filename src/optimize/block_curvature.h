// B + L of maps that step together, and steps by it.
#pragma once

#include "optimize/regularizer.h"

#include <cstddef>
#include <span>
#include <vector>

namespace cmpg {

// Of entries of one map and of others at the same texel, whose entries make up its block: the first map's, then the second's and so on.
struct CrossCurvature {
    // By texel, what is below the diagonal of its block, row by row. Empty before it was measured.
    std::vector<float> below;

    static constexpr std::size_t count(std::size_t block) { return block * (block - 1) / 2; }
    static constexpr std::size_t place(std::size_t row, std::size_t column) { return count(row) + column; } // column < row
};

// One of several maps with as many texels along each side, on one of the grids.
struct MapOnGrid {
    const TotalVariationBound* known; // L
    std::size_t entry;                // its first, of the vectors that hold the entries of all maps, one map after the other
    std::size_t place;                // of its first channel in the block of a texel
    double damping;                   // added to its diagonal, over all texels
    double stray;                     // as in TextureCurvature
};

// What a step of all maps on one grid is solved with.
struct MapsOnGrid {
    std::vector<MapOnGrid> maps;
    std::vector<float> diagonal, gradient, half; // of all entries; the last two as in NoisyGradient
    CrossCurvature cross;

    std::size_t texels() const { return maps[0].known->grid().width * maps[0].known->grid().height; }
    std::size_t block() const { return maps.back().place + maps.back().known->grid().channels; } // entries of one
    // Of map m.
    std::size_t channels(std::size_t m) const { return maps[m].known->grid().channels; }
    std::size_t entries(std::size_t m) const { return maps[m].known->grid().entries(); }
    // out = (B + L) x as it was measured.
    void multiply(std::span<const float> x, std::span<float> out) const;
};

// B + L, with B made positive: noise may have made more of what is off its diagonals than these allow.
class BlockCurvature {
  public:
    // `deviation`: of the noise of the gradient's entries. Over `stray` it is added to the diagonal, as the damping is and a thousandth of the map's mean. The
    // grid's `cross` becomes what is off the diagonals of a positive B. `grid` outlives it.
    BlockCurvature(MapsOnGrid& grid, std::span<const float> deviation);
    // g^T diag(B + L)^-1 g
    double length(std::span<const float> gradient) const;
    // (B + L)^-1 g, by conjugate gradients with the blocks of texels as the preconditioner.
    std::vector<float> solve(std::vector<float> gradient) const;

    static constexpr std::size_t kMostEntries = 16; // of a block

  private:
    void factorise(CrossCurvature& cross);
    double precondition(std::span<const float> residual, std::span<float> out) const; // returns residual . out

    const MapsOnGrid& grid_;
    std::vector<float> own_, diagonal_; // of B, of B + L
    std::vector<float> factors_; // Cholesky's, of the blocks of B with the diagonal of L; row by row, with the inverse of the diagonal
};

} // namespace cmpg

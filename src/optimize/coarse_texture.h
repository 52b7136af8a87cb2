// A texture's entries on a coarser grid: what a step of many texels together is solved on.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cmpg {

// Texels of a grid with the channels of one, and whether it repeats.
struct TextureGrid {
    std::size_t width = 1, height = 1, channels = 1;
    bool wrapU = false, wrapV = false;

    std::size_t entries() const { return width * height * channels; }
    // One texel for `factor` along each side, rounded up.
    TextureGrid coarser(std::size_t factor = 4) const;
};

// Between a grid and the coarser one: P interpolates linearly between the centres of coarse texels, and is constant beyond the outermost where nothing
// repeats. Each of its rows sums to 1. Sums have a fixed order.
class CoarseTexture {
  public:
    explicit CoarseTexture(const TextureGrid& fine, std::size_t factor = 4); // fine.coarser(factor)
    const TextureGrid& fine() const { return fine_; }
    const TextureGrid& coarse() const { return coarse_; }
    std::size_t factor() const { return factor_; }
    // P^T x, coarse().entries().
    std::vector<float> gather(std::span<const float> x) const;
    // Of the texels that are one of the coarse grid, weighted as P^T has it. Nothing of nothing.
    std::vector<float> meanOf(std::span<const float> x) const;
    // x += P coarse.
    void spread(std::span<const float> coarse, std::span<float> x) const;
    // By fine texel, of the coarse one that it is most a part of.
    template <class Value> std::vector<Value> nearest(const std::vector<Value>& coarse) const;

  private:
    struct Between { // of a fine row or column: the coarse ones about it, and the share of the second
        std::size_t first, second;
        float share;
    };
    static std::vector<Between> between(std::size_t fine, std::size_t coarse, bool wraps);

    std::size_t factor_;
    TextureGrid fine_, coarse_;
    std::vector<Between> columns_, rows_;
    std::vector<std::vector<std::size_t>> rowsOf_; // by coarse row: the fine ones it is part of
};

template <class Value> std::vector<Value> CoarseTexture::nearest(const std::vector<Value>& coarse) const {
    const auto most = [](const Between& at) { return at.share > 0.5f ? at.second : at.first; };
    std::vector<Value> fine;
    fine.reserve(fine_.width * fine_.height);
    for (const Between& row : rows_)
        for (const Between& column : columns_)
            fine.push_back(coarse[most(row) * coarse_.width + most(column)]);
    return fine;
}

} // namespace cmpg

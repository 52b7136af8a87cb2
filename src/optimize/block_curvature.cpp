// B + L of maps that step together, and steps by it.
#include "optimize/block_curvature.h"

#include "optimize/conjugate_gradients.h"
#include "optimize/entry_loops.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace cmpg {
namespace {

constexpr std::size_t kTexelsAtOnce = 1024;
constexpr double kLeastCurvature = 1e-3; // of the mean: entries that no path met in the passes that measured it

using Block = std::array<float, BlockCurvature::kMostEntries>; // the entries of a texel
constexpr std::size_t factorsOf(std::size_t block) { return CrossCurvature::count(block + 1); } // with the diagonal

// Calls texel(its number, a function that calls entry(place in the block, place in the vectors of all entries) for each of its entries).
template <class Texel> void forTexels(const MapsOnGrid& grid, std::size_t begin, std::size_t end, const Texel& texel) {
    for (std::size_t t = begin; t < end; ++t)
        texel(t, [&](const auto& entry) {
            for (std::size_t m = 0; m < grid.maps.size(); ++m)
                for (std::size_t c = 0; c < grid.channels(m); ++c)
                    entry(grid.maps[m].place + c, grid.maps[m].entry + t * grid.channels(m) + c);
        });
}

// out += what is off the diagonals of blocks, times x.
void addCross(const MapsOnGrid& grid, std::span<const float> x, std::span<float> out) {
    const CrossCurvature& cross = grid.cross;
    if (cross.below.empty())
        return;
    const std::size_t size = grid.block(), count = CrossCurvature::count(size);
    parallelFor(grid.texels(), kTexelsAtOnce, [&](std::size_t begin, std::size_t end) {
        forTexels(grid, begin, end, [&](std::size_t t, const auto& forEntries) {
            Block from{}, to{};
            forEntries([&](std::size_t place, std::size_t entry) { from[place] = x[entry]; });
            const float* below = cross.below.data() + t * count;
            for (std::size_t row = 1; row < size; ++row)
                for (std::size_t column = 0; column < row; ++column, ++below) {
                    to[row] += *below * from[column];
                    to[column] += *below * from[row];
                }
            forEntries([&](std::size_t place, std::size_t entry) { out[entry] += to[place]; });
        });
    });
}

// out = (`own` + L + what is off the diagonals of blocks) x
void multiplyMaps(const MapsOnGrid& grid, std::span<const float> own, std::span<const float> x, std::span<float> out) {
    for (std::size_t m = 0; m < grid.maps.size(); ++m) {
        const std::size_t first = grid.maps[m].entry, count = grid.entries(m);
        if (grid.maps[m].known->empty())
            forEachEntry(count, [&](std::size_t i) { out[first + i] = own[first + i] * x[first + i]; });
        else
            grid.maps[m].known->multiply(own.subspan(first, count), x.subspan(first, count), out.subspan(first, count));
    }
    addCross(grid, x, out);
}

// The lower triangle, row by row, becomes its factor in place. False where little is left of an entry of the diagonal: less than `least` of it.
bool factorise(std::span<float> triangle, std::size_t size, float least) {
    const auto at = [&](std::size_t row, std::size_t column) -> float& { return triangle[CrossCurvature::count(row + 1) + column]; };
    for (std::size_t row = 0; row < size; ++row) {
        for (std::size_t column = 0; column < row; ++column) {
            float value = at(row, column);
            for (std::size_t k = 0; k < column; ++k)
                value -= at(row, k) * at(column, k);
            at(row, column) = value * at(column, column);
        }
        const float whole = at(row, row);
        float pivot = whole;
        for (std::size_t k = 0; k < row; ++k)
            pivot -= at(row, k) * at(row, k);
        if (whole > 0 && !(pivot > least * whole))
            return false;
        at(row, row) = pivot > 0 ? 1 / std::sqrt(pivot) : 0.f;
    }
    return true;
}

} // namespace

void MapsOnGrid::multiply(std::span<const float> x, std::span<float> out) const { multiplyMaps(*this, diagonal, x, out); }

BlockCurvature::BlockCurvature(MapsOnGrid& grid, std::span<const float> deviation) : grid_(grid), own_(grid.diagonal) {
    for (std::size_t m = 0; m < grid.maps.size(); ++m) {
        const MapOnGrid& map = grid.maps[m];
        const std::size_t count = grid.entries(m);
        float* const own = own_.data() + map.entry;
        const double mean = sumOfEntries(count, [&](std::size_t i) { return double(own[i]); }) / double(count);
        const auto least = float(kLeastCurvature * mean + map.damping), stray = float(std::min(map.stray, 1e30));
        forEachEntry(count, [&](std::size_t i) { own[i] += least + deviation[map.entry + i] / stray; });
    }
    diagonal_ = own_;
    for (std::size_t m = 0; m < grid.maps.size(); ++m)
        if (const MapOnGrid& map = grid.maps[m]; !map.known->empty())
            map.known->diagonal(std::span(own_).subspan(map.entry, grid.entries(m)), std::span(diagonal_).subspan(map.entry, grid.entries(m)));
    factorise(grid.cross);
}

void BlockCurvature::factorise(CrossCurvature& cross) {
    constexpr float kLeastPivot = 1e-3f; // of an entry: what the others leave of it
    constexpr int kAttempts = 12;
    constexpr float kLess = 0.85f; // of what is off the diagonal, in each
    const std::size_t size = grid_.block(), count = CrossCurvature::count(size), factors = factorsOf(size);
    factors_.resize(grid_.texels() * factors);
    parallelFor(grid_.texels(), kTexelsAtOnce, [&](std::size_t begin, std::size_t end) {
        forTexels(grid_, begin, end, [&](std::size_t t, const auto& forEntries) {
            Block own{}, whole{};
            forEntries([&](std::size_t place, std::size_t entry) {
                own[place] = own_[entry];
                whole[place] = diagonal_[entry];
            });
            std::array<float, factorsOf(kMostEntries)> triangle;
            const std::span<float> block(triangle.data(), factors);
            float* const below = cross.below.empty() ? nullptr : cross.below.data() + t * count;
            const auto fill = [&](const Block& diagonal, float times) {
                for (std::size_t row = 0, k = 0; row < size; ++row) {
                    for (std::size_t column = 0; column < row; ++column, ++k) {
                        const float most = std::sqrt(own[row]) * std::sqrt(own[column]); // the product may underflow
                        block[CrossCurvature::count(row + 1) + column] = below ? times * std::clamp(below[k], -most, most) : 0.f;
                    }
                    block[CrossCurvature::count(row + 1) + row] = diagonal[row];
                }
            };
            // Of B alone: L makes neighbours alike, and no entry of a texel like another.
            float times = 1;
            for (int attempt = 0; attempt < kAttempts; ++attempt, times *= kLess) {
                fill(own, times);
                if (cmpg::factorise(block, size, kLeastPivot))
                    break;
                if (attempt + 1 == kAttempts)
                    times = 0;
            }
            fill(whole, times);
            for (std::size_t row = 1, k = 0; below && row < size; ++row)
                for (std::size_t column = 0; column < row; ++column, ++k)
                    below[k] = block[CrossCurvature::count(row + 1) + column];
            cmpg::factorise(block, size, 0);
            std::copy(block.begin(), block.end(), factors_.begin() + std::ptrdiff_t(t * factors));
        });
    });
}

double BlockCurvature::length(std::span<const float> gradient) const {
    return sumOfEntries(gradient.size(), [&](std::size_t i) { return diagonal_[i] > 0 ? double(gradient[i]) * gradient[i] / diagonal_[i] : 0.0; });
}

double BlockCurvature::precondition(std::span<const float> residual, std::span<float> out) const {
    const std::size_t size = grid_.block(), factors = factorsOf(size);
    return orderedSum<double>(grid_.texels(), kTexelsAtOnce, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        forTexels(grid_, begin, end, [&](std::size_t t, const auto& forEntries) {
            Block v{};
            forEntries([&](std::size_t place, std::size_t entry) { v[place] = residual[entry]; });
            const float* const f = factors_.data() + t * factors;
            for (std::size_t row = 0; row < size; ++row) {
                const float* const of = f + CrossCurvature::count(row + 1);
                for (std::size_t column = 0; column < row; ++column)
                    v[row] -= of[column] * v[column];
                v[row] *= of[row];
            }
            for (std::size_t row = size; row-- > 0;) {
                for (std::size_t below = row + 1; below < size; ++below)
                    v[row] -= f[CrossCurvature::count(below + 1) + row] * v[below];
                v[row] *= f[CrossCurvature::count(row + 1) + row];
            }
            forEntries([&](std::size_t place, std::size_t entry) {
                out[entry] = v[place];
                sum += double(residual[entry]) * v[place];
            });
        });
        return sum;
    });
}

std::vector<float> BlockCurvature::solve(std::vector<float> gradient) const {
    std::vector<float> scaled(gradient.size());
    precondition(gradient, scaled);
    return conjugateGradients(
        std::move(gradient), std::move(scaled), [&](std::span<const float> x, std::span<float> out) { multiplyMaps(grid_, own_, x, out); },
        [&](float step, const std::vector<float>& direction, const std::vector<float>& image, std::vector<float>& x, std::vector<float>& residual, std::vector<float>& z) {
            forEachEntry(x.size(), [&](std::size_t i) {
                x[i] += step * direction[i];
                residual[i] -= step * image[i];
            });
            return precondition(residual, z);
        });
}

} // namespace cmpg

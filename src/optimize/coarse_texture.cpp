// A texture's entries on a coarser grid.
#include "optimize/coarse_texture.h"

#include "base/parallel.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr std::size_t kRowsAtOnce = 4; // of the coarse grid

} // namespace

TextureGrid TextureGrid::coarser(std::size_t factor) const {
    TextureGrid grid = *this;
    grid.width = (width + factor - 1) / factor;
    grid.height = (height + factor - 1) / factor;
    grid.wrapU = wrapU && grid.width > 1;
    grid.wrapV = wrapV && grid.height > 1;
    return grid;
}

CoarseTexture::CoarseTexture(const TextureGrid& fine, std::size_t factor)
    : factor_(factor), fine_(fine), coarse_(fine.coarser(factor)), columns_(between(fine.width, coarse_.width, fine.wrapU)), rows_(between(fine.height, coarse_.height, fine.wrapV)),
      rowsOf_(coarse_.height) {
    for (std::size_t y = 0; y < fine.height; ++y) {
        rowsOf_[rows_[y].first].push_back(y);
        if (rows_[y].second != rows_[y].first)
            rowsOf_[rows_[y].second].push_back(y);
    }
}

std::vector<CoarseTexture::Between> CoarseTexture::between(std::size_t fine, std::size_t coarse, bool wraps) {
    std::vector<Between> result;
    const auto last = std::ptrdiff_t(coarse) - 1;
    for (std::size_t i = 0; i < fine; ++i) {
        const double place = (double(i) + 0.5) * double(coarse) / double(fine) - 0.5;
        const auto first = std::ptrdiff_t(std::floor(place));
        const auto inside = [&](std::ptrdiff_t at) { return std::size_t(wraps ? (at + last + 1) % (last + 1) : std::clamp<std::ptrdiff_t>(at, 0, last)); };
        result.push_back({inside(first), inside(first + 1), float(place - double(first))});
    }
    return result;
}

std::vector<float> CoarseTexture::gather(std::span<const float> x) const {
    const std::size_t channels = fine_.channels, row = fine_.width * channels, coarseRow = coarse_.width * channels;
    std::vector<float> result(coarse_.entries());
    parallelFor(coarse_.height, kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
        std::vector<float> sum(row); // of the fine rows of a coarse one: along rows loops can be vectorised
        for (std::size_t j = begin; j < end; ++j) {
            std::fill(sum.begin(), sum.end(), 0.f);
            for (const std::size_t y : rowsOf_[j]) {
                const Between& at = rows_[y];
                const float weight = (at.first == j ? 1 - at.share : 0.f) + (at.second == j ? at.share : 0.f);
                const float* in = x.data() + y * row;
                for (std::size_t i = 0; i < row; ++i)
                    sum[i] += weight * in[i];
            }
            float* out = result.data() + j * coarseRow;
            for (std::size_t i = 0; i < fine_.width; ++i)
                for (std::size_t c = 0; c < channels; ++c) {
                    const float value = sum[i * channels + c];
                    out[columns_[i].first * channels + c] += (1 - columns_[i].share) * value;
                    out[columns_[i].second * channels + c] += columns_[i].share * value;
                }
        }
    });
    return result;
}

std::vector<float> CoarseTexture::meanOf(std::span<const float> x) const {
    if (x.empty())
        return {};
    std::vector<float> mean = gather(x);
    const std::vector<float> weights = gather(std::vector<float>(x.size(), 1.f));
    for (std::size_t i = 0; i < mean.size(); ++i)
        mean[i] /= weights[i];
    return mean;
}

void CoarseTexture::spread(std::span<const float> coarse, std::span<float> x) const {
    const std::size_t channels = fine_.channels, row = fine_.width * channels, coarseRow = coarse_.width * channels;
    parallelFor(fine_.height, 4 * kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
        std::vector<float> between(coarseRow); // two coarse rows
        for (std::size_t y = begin; y < end; ++y) {
            const Between& at = rows_[y];
            const float *above = coarse.data() + at.first * coarseRow, *below = coarse.data() + at.second * coarseRow;
            for (std::size_t i = 0; i < coarseRow; ++i)
                between[i] = (1 - at.share) * above[i] + at.share * below[i];
            for (std::size_t i = 0; i < fine_.width; ++i)
                for (std::size_t c = 0; c < channels; ++c)
                    x[y * row + i * channels + c] += (1 - columns_[i].share) * between[columns_[i].first * channels + c] +
                                                     columns_[i].share * between[columns_[i].second * channels + c];
        }
    });
}

} // namespace cmpg

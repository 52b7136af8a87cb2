// Which pixels of a view get the samples of its images.
#include "optimize/pixel_shares.h"

#include <algorithm>
#include <cmath>

namespace cmpg {

void PixelAnswers::add(const Image& a, const Image& b, std::span<const float> mask) {
    product_.resize(a.pixels());
    square_.resize(a.pixels());
    masked_.resize(mask.size());
    for (std::size_t p = 0; p < product_.size(); ++p) {
        if (!mask.empty() && mask[p] == 0) {
            masked_[p] = true;
            continue;
        }
        float product = 0, square = 0;
        for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) {
            product += a.values[i] * b.values[i];
            square += 0.5f * (a.values[i] * a.values[i] + b.values[i] * b.values[i]);
        }
        if (!std::isfinite(square_[p] + square)) // which bounds the product's as well
            continue;
        product_[p] += product;
        square_[p] += square;
    }
}

std::vector<float> PixelAnswers::shares(int width, int height) const {
    std::vector<float> shares(product_.size());
    double both = 0, each = 0, count = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (isMasked(std::size_t(y) * width + x))
                continue;
            ++count;
            double product = 0, square = 0;
            for (int v = std::max(0, y - 1); v <= std::min(height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(width - 1, x + 1); ++u) {
                    product += product_[std::size_t(v) * width + u];
                    square += square_[std::size_t(v) * width + u];
                }
            both += shares[std::size_t(y) * width + x] = float(std::sqrt(std::max(0.0, product)));
            each += std::sqrt(square);
        }
    if (!(both > 0))
        return {};
    const double known = std::min(1.0, both / each), all = double(shares.size());
    for (std::size_t p = 0; p < shares.size(); ++p)
        shares[p] = isMasked(p) ? 0.f : float(all * (known * shares[p] / both + (1 - known) / count));
    return shares;
}

} // namespace cmpg

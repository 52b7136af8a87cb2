// The variance of a reverse pass, from what its paths contributed.
#pragma once

#include "shared/wavefront.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace cmpg {

// Paths come in pixel order. A pixel has a fixed number of samples, so what its samples agree on is no variance: of the contributions of
// first vertices, which go to few entries, the mean is taken out per pixel and entry. Those of later vertices scatter over many entries;
// their squares count whole. The result does not depend on how the paths were batched.
class MomentSum {
  public:
    void add(std::size_t pixel, const gpu::PathMoment& m) {
        if (pixel != pixel_) {
            closePixel();
            pixel_ = pixel;
        }
        below_ += double(m.below) * double(m.below);
        reference_ += double(m.reference);
        ++samples_;
        const glm::dvec3 own(m.own);
        const double square = glm::dot(own, own);
        squares_ += square;
        weigh(square + double(m.below) * double(m.below));
        if (m.entry == gpu::kNone)
            return;
        for (std::size_t i = 0; i < entries_; ++i)
            if (sums_[i].entry == m.entry) {
                sums_[i].sum += own;
                return;
            }
        if (entries_ < kMostEntries) // beyond, a pixel sees so many that its samples agree on little
            sums_[entries_++] = {m.entry, own};
    }

    // Sum over the gradient's entries of the variance, for the samples so far.
    double variance() {
        closePixel();
        // Pixels of one sample tell nothing about their mean: they are taken to scatter as the others do.
        const double share = pairedSquares_ > 0 ? std::clamp(pairedVariance_ / pairedSquares_, 0.0, 1.0) : 1;
        return below_ + pairedSquares_ * share + singleSquares_ * share;
    }
    double reference() const { return reference_; } // sum over the paths
    // Share of the kLargest largest paths in the sum of all squares: near 1, a few samples are the result.
    double concentration() const { return total_ > 0 ? std::accumulate(largest_.begin(), largest_.end(), 0.0) / total_ : 0; }
    static constexpr std::size_t kLargest = 8;

  private:
    struct EntrySum {
        std::uint32_t entry;
        glm::dvec3 sum;
    };

    // Keeps the largest in descending order, so that their sum does not depend on the order they came in.
    void weigh(double square) {
        total_ += square;
        for (std::size_t i = kLargest; i-- > 0 && square > largest_[i];) {
            if (i + 1 < kLargest)
                largest_[i + 1] = largest_[i];
            largest_[i] = square;
        }
    }

    void closePixel() {
        if (samples_ == 1)
            singleSquares_ += squares_;
        if (samples_ > 1) {
            double products = -squares_; // of pairs of different samples with the same entry
            for (std::size_t i = 0; i < entries_; ++i)
                products += glm::dot(sums_[i].sum, sums_[i].sum);
            pairedSquares_ += squares_;
            pairedVariance_ += squares_ - products / double(samples_ - 1);
        }
        samples_ = 0;
        squares_ = 0;
        entries_ = 0;
    }

    std::size_t pixel_ = ~std::size_t(0), samples_ = 0;
    double squares_ = 0;
    static constexpr std::size_t kMostEntries = 16;
    std::array<EntrySum, kMostEntries> sums_;
    std::size_t entries_ = 0;
    std::array<double, kLargest> largest_{};
    double total_ = 0;
    double below_ = 0, reference_ = 0, pairedSquares_ = 0, pairedVariance_ = 0, singleSquares_ = 0;
};

} // namespace cmpg

// What a comparison of a derivative with finite differences found.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace cmpg {

// A mean of the derivative image, of one channel or of a block of pixels, both ways.
struct Comparison {
    std::string what = {};          // "red mean", "block 3,5" (column, row)
    double forward = 0, finite = 0; // means over the repetitions
    double standardError = 0;       // joint
    double systematic = 0;          // bound of truncation and rounding of the finite difference
    double probability = 1;         // of so large a deviation by chance
    double z() const { return standardError > 0 ? (forward - finite) / standardError : 0; }
    double relativeError() const { return finite != 0 ? (forward - finite) / std::abs(finite) : forward == 0 ? 0 : kInfinite; } // of the finite difference
    double power() const { return finite != 0 ? (3 * standardError + systematic) / std::abs(finite) : kInfinite; } // least relative error that stands out
    // Both sides are zero within their errors: no relative error to speak of.
    bool vanishes() const { return std::max(std::abs(forward), std::abs(finite)) <= 3 * standardError + systematic; }

  private:
    static constexpr double kInfinite = std::numeric_limits<double>::infinity();
};

struct CheckResult {
    unsigned repetitions = 0;                 // of both sides, with random numbers of their own
    double step = 0;                          // of the stencil, in units of the direction
    std::vector<Comparison> comparisons = {}; // the mean of each channel, then blocks
    double threshold = 0;                     // a comparison with a lower probability is a disagreement, and one of NaN
    bool agrees() const {
        for (const Comparison& comparison : comparisons)
            if (!(comparison.probability >= threshold))
                return false;
        return true;
    }
};

} // namespace cmpg

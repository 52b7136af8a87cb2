// Newton steps of constants: few entries, whose effects on an image may cancel each other, with the whole matrix of their curvature.
#pragma once

#include "optimize/optimizer.h"
#include "scene/image.h"

#include <array>
#include <span>
#include <vector>

namespace cmpg {

// Parameters of a block, and of their entries; each costs an image whenever the curvature is measured, and memory for it.
constexpr std::size_t kMostConstants = 8;
constexpr std::size_t kMostConstantPixels = std::size_t(1) << 25;

// How images change with some entries of a constant: of one view.
struct ConstantColumn {
    std::array<Image, 2> half; // halves of the change, with random numbers of their own
    std::uint32_t entries = 1; // one that changes all channels of the image, or three, of which entry c changes channel c alone
    double step = 1;           // by how much they were changed
};

// J^T W J, with J the derivative of images by the entries of all columns, added up over views. Both K x K, row by row.
struct ConstantProducts {
    std::vector<double> mean;     // without bias: of one half by the other, whose noise is its own
    std::vector<double> variance; // of that, from how pixels of the halves differ

    explicit ConstantProducts(std::size_t entries) : mean(entries * entries), variance(entries * entries) {}
};

// Adds those of a view. `weight`: the diagonal of W.
void addProducts(std::span<const ConstantColumn> columns, const Image& weight, ConstantProducts& products);

// What is known of the loss' Hessian H by these entries, K of them. It has all their couplings, of either sign: metallic lowers where colour raises.
struct ConstantCurvature {
    std::vector<double> matrix; // K x K, row by row; empty before it was measured
    std::vector<double> noise;  // the standard deviations of its entries
    std::vector<double> others; // K: bounds what couples entries to parameters that move beside them
    std::vector<float> at;      // K: values where it was last measured

    bool empty() const { return matrix.empty(); }
    // Later measurements count by half, or alone where the last one is old.
    void add(const ConstantProducts& products, std::span<const float> values, std::span<const double> range);
    // Adds to `others` what a bound on the whole tells: `product` = H d over all parameters, whose d of other entries is not negative, with `direction` = d of
    // these, 0 where they stayed, and `unit` a positive size of a change of each.
    void addOthers(std::span<const double> product, std::span<const double> direction, std::span<const double> unit);
    // Whether values have left where it was measured, so far that it may have changed. `range`: over which the images are about linear in each.
    bool isOld(std::span<const float> values, std::span<const double> range) const;
    // Whether the diagonal of an entry is no larger than its noise.
    bool isHidden(std::size_t entry) const;
    // Whether a diagonal is not known to a factor of two, by one standard deviation.
    bool isNoisy() const;
};

// The gradient by these entries. That of the last step; where noise hides the curvature, and steps are short, from more of them: while values hardly move, the
// gradients of steps are of the same values, and their noise averages out. After a move of a whole range what they say may be off by all of it (a
// Kalman filter, entry by entry).
struct CarriedGradient {
    std::vector<double> mean, variance; // K, of the values `at`; empty before the first step
    std::vector<double> squares;        // K: the variance of one step's gradient, averaged
    std::vector<float> at;              // K
    // `gradient` of a step at `values`, `half`: half of how two independent halves of it differ. `range`: as in ConstantCurvature::isOld.
    void advance(const ConstantCurvature& curvature, std::span<const float> values, std::span<const double> range, std::span<const double> gradient,
                 std::span<const double> half);
};

// The minimum of g x + x M x / 2 for x within bounds that contain 0. M is symmetric; entries without a positive diagonal stay at 0.
std::vector<double> boxMinimum(std::span<const double> matrix, std::span<const double> gradient, std::span<const double> lowest, std::span<const double> highest);

// By how much the entries should change: to that minimum, with M the measured curvature and a ridge as large as its noise, times the share
// of the signal in what the gradient promises, averaged over steps in `moments`. A diagonal that noise has made negative is the ridge alone. `half`: as large as the noise of the gradient, of any sign.
// An entry whose curvature noise hides goes up to `rate` at least, the farther the surer its slope is: Adam goes as far. 0: no farther than the rest says.
std::vector<double> constantStep(const ConstantCurvature& curvature, std::span<const double> gradient, std::span<const double> half,
                                 std::span<const double> lowest, std::span<const double> highest, std::span<const double> rate, Moments& moments);

} // namespace cmpg

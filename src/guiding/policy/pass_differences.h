// The variance of a method of sampling, from how the results of its passes differ.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace cmpg {

// Half the squared difference of two passes with random numbers of their own is the variance of either, summed over the result's entries.
// Moments of single paths take the samples of a pixel for independent; only this sees what Sobol points gain.
class PassDifferences {
  public:
    // `result`: a pass's estimate, always as many entries. All passes have as many samples.
    void add(std::span<const double> result);
    // Of the last two passes, the earlier pairs counting less. Empty before two passes, and where so few entries differ that their squares
    // say little: the relative standard error of each pair is held below a third.
    std::optional<double> variance() const { return variance_; }

    // Of two passes alone, whether or not so few entries share it that it says little.
    struct Pair {
        double variance;
        bool telling;
    };
    static Pair compare(std::span<const double> a, std::span<const double> b);
    // The variance of two passes alone, of which nothing is kept: their gradients by parameter. Empty where it would say little.
    static std::optional<double> varianceOf(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b);

  private:
    std::vector<float> last_;
    std::optional<double> variance_;
};

// How many times the variance of one method is that of another: the worse of two estimates, `moments`, the ratio of their paths' moments, and that of
// differences, where both methods have one. Only differences see what Sobol points gain, and a few bright paths in the passes of the other method
// make the one look good in them; moments have more to go by.
double worseVarianceRatio(double moments, const PassDifferences& method, const PassDifferences& other);

} // namespace cmpg

// The variance of a method of sampling, from how the results of its passes differ.
#include "guiding/policy/pass_differences.h"

#include <algorithm>

namespace cmpg {
namespace {

constexpr double kPairWeight = 0.5; // of the latest pair
// Entries that share the squared difference, (sum d^2)^2 / sum d^4. For normal differences the sum's relative standard error is the root
// of 2 over it.
constexpr double kLeastParticipation = 18;

} // namespace

void PassDifferences::add(std::span<const double> result) {
    if (last_.size() == result.size() && !last_.empty()) {
        double squares = 0, fourths = 0;
        for (std::size_t i = 0; i < result.size(); ++i) {
            const double d = result[i] - double(last_[i]), square = d * d;
            squares += square;
            fourths += square * square;
        }
        if (squares * squares < kLeastParticipation * fourths)
            variance_.reset();
        else
            variance_ = variance_ ? *variance_ + kPairWeight * (squares / 2 - *variance_) : squares / 2;
    }
    last_.assign(result.begin(), result.end());
}

double worseVarianceRatio(double moments, const PassDifferences& method, const PassDifferences& other) {
    const std::optional<double> mine = method.variance(), theirs = other.variance();
    return mine && theirs && *theirs > 0 ? std::max(moments, *mine / *theirs) : moments;
}

} // namespace cmpg

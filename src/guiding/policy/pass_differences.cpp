// The variance of a method of sampling, from how the results of its passes differ.
#include "guiding/policy/pass_differences.h"

#include <algorithm>

namespace cmpg {
namespace {

constexpr double kPairWeight = 0.5; // of the latest pair
// Entries that share the squared difference, (sum d^2)^2 / sum d^4. For normal differences the sum's relative standard error is the root
// of 2 over it.
constexpr double kLeastParticipation = 18;

struct Differences {
    double squares = 0, fourths = 0;
    void add(double difference) {
        const double square = difference * difference;
        squares += square;
        fourths += square * square;
    }
    bool telling() const { return !(squares * squares < kLeastParticipation * fourths); }
    std::optional<double> variance() const { return telling() ? std::optional(squares / 2) : std::nullopt; }
};

} // namespace

void PassDifferences::add(std::span<const double> result) {
    if (last_.size() == result.size() && !last_.empty()) {
        Differences pair;
        for (std::size_t i = 0; i < result.size(); ++i)
            pair.add(result[i] - double(last_[i]));
        const std::optional<double> found = pair.variance();
        variance_ = found && variance_ ? *variance_ + kPairWeight * (*found - *variance_) : found;
    }
    last_.assign(result.begin(), result.end());
}

PassDifferences::Pair PassDifferences::compare(std::span<const double> a, std::span<const double> b) {
    Differences pair;
    for (std::size_t i = 0; i < a.size(); ++i)
        pair.add(b[i] - a[i]);
    return {pair.squares / 2, pair.telling()};
}

std::optional<double> PassDifferences::varianceOf(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b) {
    Differences pair;
    for (std::size_t p = 0; p < a.size(); ++p)
        for (std::size_t i = 0; i < a[p].size(); ++i)
            pair.add(b[p][i] - a[p][i]);
    return pair.variance();
}

double worseVarianceRatio(double moments, const PassDifferences& method, const PassDifferences& other) {
    const std::optional<double> mine = method.variance(), theirs = other.variance();
    return mine && theirs && *theirs > 0 ? std::max(moments, *mine / *theirs) : moments;
}

} // namespace cmpg

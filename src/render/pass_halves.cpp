// Passes in two halves with random numbers of their own.
#include "render/pass_halves.h"

#include "base/parallel.h"

#include <cmath>

namespace cmpg {
namespace {

constexpr std::uint32_t kSecondHalf = 5;
constexpr std::size_t kEntriesAtOnce = 1 << 15;

} // namespace

PassKey secondHalf(const PassKey& key) { return {key.seed, key.step, key.pass + kSecondHalf, key.firstSample}; }

PassResult meanOf(PassResult a, const PassResult& b) {
    a.add(b);
    a.variance /= 2;
    a.reference /= 2;
    return a;
}

void addHalf(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b, double sign, std::vector<std::vector<double>>& sum) {
    sum.resize(a.size());
    for (std::size_t p = 0; p < a.size(); ++p) {
        sum[p].resize(a[p].size());
        parallelFor(a[p].size(), kEntriesAtOnce, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                sum[p][i] += 0.5 * (a[p][i] + sign * b[p][i]);
        });
    }
}

std::vector<double> entries(const Image& image) {
    std::vector<double> all(image.values.begin(), image.values.end());
    for (double& v : all)
        v /= std::sqrt(double(image.channels));
    return all;
}

std::vector<double> entries(const std::vector<std::vector<double>>& gradients) {
    std::vector<double> all;
    for (const std::vector<double>& g : gradients)
        all.insert(all.end(), g.begin(), g.end());
    return all;
}

} // namespace cmpg

// How much to sample: an estimate made of batches with random numbers of their own, its error, and when there is enough of it.
#include "optimize/error_budget.h"

#include "base/student_t.h"
#include "optimize/ordered_sum.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

namespace cmpg {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kReserve = 0.95; // of the time left, for a last stage whose speed is that of the one before

std::vector<double> meanOf(std::span<const std::vector<float>> batches) {
    std::vector<double> mean(batches.front().size());
    for (const auto& batch : batches)
        for (std::size_t i = 0; i < mean.size(); ++i)
            mean[i] += double(batch[i]);
    for (double& m : mean)
        m /= double(batches.size());
    return mean;
}

using Matrix = std::vector<std::vector<double>>;

// A sum of products of batches, the lower triangle.
struct Products {
    std::vector<double> sums;
    Products& operator+=(const Products& other) {
        sums.resize(other.sums.size());
        for (std::size_t i = 0; i < sums.size(); ++i)
            sums[i] += other.sums[i];
        return *this;
    }
};

// Inner products of the deviations from the mean.
Matrix products(std::span<const std::vector<float>> batches, const std::vector<double>& mean) {
    constexpr std::size_t kAtOnce = 1 << 14;
    const std::size_t n = batches.size();
    const Products found = orderedSum<Products>(mean.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
        Products part{std::vector<double>(n * (n + 1) / 2)};
        std::vector<double> deviation(n);
        for (std::size_t e = begin; e < end; ++e) {
            for (std::size_t i = 0; i < n; ++i)
                deviation[i] = double(batches[i][e]) - mean[e];
            double* sum = part.sums.data();
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t j = 0; j <= i; ++j)
                    *sum++ += deviation[i] * deviation[j];
        }
        return part;
    });
    Matrix inner(n, std::vector<double>(n));
    auto next = found.sums.begin();
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j <= i; ++j)
            inner[i][j] = inner[j][i] = *next++;
    return inner;
}

// tr(S^2) of the covariance S of vectors with these inner products: the mean of <a - b, c - d>^2 / 4 over all choices of four. Unbiased whatever the
// distribution. In closed form (Himeno and Yamada 2014, Estimations for some functions of covariance matrix in high dimension under non-normality).
double squaredCovariance(const Matrix& inner) {
    const double n = double(inner.size());
    std::vector<double> means;
    double all = 0;
    for (const std::vector<double>& row : inner) {
        means.push_back(std::accumulate(row.begin(), row.end(), 0.0) / n);
        all += means.back() / n;
    }
    double squares = 0, own = 0, fourth = 0; // of deviations from the mean of these vectors
    for (std::size_t i = 0; i < inner.size(); ++i)
        for (std::size_t j = 0; j < inner.size(); ++j) {
            const double product = inner[i][j] - means[i] - means[j] + all;
            squares += product * product;
            own += i == j ? product : 0;
            fourth += i == j ? product * product : 0;
        }
    return ((n - 1) * (n - 2) * squares + own * own - n * (n - 1) * fourth) / (n * (n - 1) * (n - 2) * (n - 3));
}

// Of the covariance of a batch.
double trace(const Matrix& inner) {
    const double n = double(inner.size());
    double own = 0, all = 0;
    for (std::size_t i = 0; i < inner.size(); ++i) {
        own += inner[i][i];
        all += std::accumulate(inner[i].begin(), inner[i].end(), 0.0);
    }
    return (own - all / n) / (n - 1); // the deviations may be from another mean
}

// tr(S^2) / tr(S)^2, the inverse of the degrees of freedom of a squared error. Between 0, of many entries alike, and 1, of one alone.
double inverseDegrees(const Matrix& inner) {
    const double t = trace(inner), squared = std::max(0.0, squaredCovariance(inner));
    const double excess = t * t - 2 * squared / double(inner.size() - 1); // t^2 is too large by that on average
    return excess > 0 ? std::min(squared / excess, 1.0) : 1;
}

// Its standard error, from leaving out each batch in turn (jackknife).
double inverseDegreesError(const Matrix& inner) {
    const std::size_t n = inner.size();
    double sum = 0, squares = 0;
    for (std::size_t left = 0; left < n; ++left) {
        Matrix rest = inner;
        rest.erase(rest.begin() + std::ptrdiff_t(left));
        for (std::vector<double>& row : rest)
            row.erase(row.begin() + std::ptrdiff_t(left));
        const double v = inverseDegrees(rest);
        sum += v;
        squares += v * v;
    }
    return std::sqrt(std::max(0.0, double(n - 1) / double(n) * (squares - sum * sum / double(n))));
}

} // namespace

EstimateError errorOf(std::span<const std::vector<float>> batches) {
    const double n = double(batches.size());
    const std::vector<double> mean = meanOf(batches);
    double norm2 = 0; // of the mean
    for (const double m : mean)
        norm2 += m * m;
    const Matrix inner = products(batches, mean);
    const double variance = trace(inner);
    if (!(norm2 > 0) || !std::isfinite(norm2) || !std::isfinite(variance))
        return {kNaN, kNaN, kNaN, kNaN};
    EstimateError error;
    error.relative = variance > 0 ? std::sqrt(variance / n / norm2) : 0;
    error.degrees = 1;
    if (!(variance > 0))
        return error;
    // The squared error of the mean over its estimate: a quotient of mean squares whose degrees of freedom follow from the first two
    // moments (Satterthwaite). The difference of the two is a sum over pairs of batches, so rare bright samples enter both alike.
    constexpr double kTail = 0.025, kMost = 1e9;
    const double inverse = inverseDegrees(inner);
    error.degrees = 1 / std::max(inverse, 1 / kMost);
    // Few batches tell the degrees with half of them as their spread, and intervals that take them as known hold too little: 89 of 100
    // in BudgetCalibration.FullGradient. With half a standard error of their inverse more it is 95 there, and 92 to 96 % of 500 in
    // SampleBudget.IntervalsHoldTheTruthWhateverTheNoise.
    const double cautious = 1 / std::clamp(inverse + 0.5 * inverseDegreesError(inner), 1 / kMost, 1.0);
    error.low = error.relative * std::sqrt(fQuantile(kTail, cautious, cautious * (n - 1)));
    error.high = error.relative * std::sqrt(fQuantile(1 - kTail, cautious, cautious * (n - 1)));
    return error;
}

BudgetedEstimate spendBudget(const SampleBudget& budget, const std::function<std::vector<double>(const BatchPart&)>& pass,
                             const std::function<void(const BudgetedEstimate&)>& shown) {
    BudgetedEstimate estimate;
    std::vector<std::vector<float>> batches(budget.batches);
    double perSample = 0; // seconds of a sample of all batches, in the last stage
    for (std::uint32_t stage = 0;; ++stage) {
        std::uint32_t samples = std::min(std::max(1u, estimate.samples), budget.samples - estimate.samples);
        bool last = false;
        if (budget.seconds && stage > 0) {
            const double affordable = perSample > 0 ? kReserve * (*budget.seconds - budget.clock()) / perSample : double(samples);
            last = affordable < double(samples);
            if (last)
                samples = std::uint32_t(std::max(0.0, affordable));
        }
        if (samples == 0) {
            estimate.end = last ? BudgetedEstimate::End::Time : BudgetedEstimate::End::Samples;
            return estimate;
        }
        const double start = budget.seconds ? budget.clock() : 0;
        const double before = double(estimate.samples), all = before + double(samples);
        for (std::uint32_t b = 0; b < budget.batches; ++b) {
            const std::vector<double> values = pass({b, stage, estimate.samples, samples});
            batches[b].resize(values.size());
            for (std::size_t i = 0; i < values.size(); ++i)
                batches[b][i] = float((before * double(batches[b][i]) + double(samples) * values[i]) / all);
        }
        if (budget.seconds)
            perSample = (budget.clock() - start) / double(samples);
        estimate.samples += samples;
        estimate.mean = meanOf(batches);
        estimate.error = errorOf(batches);
        if (shown)
            shown(estimate);
        if (budget.error && estimate.error.relative <= *budget.error) {
            estimate.end = BudgetedEstimate::End::Error;
            return estimate;
        }
        if (last) {
            estimate.end = BudgetedEstimate::End::Time;
            return estimate;
        }
    }
}

} // namespace cmpg

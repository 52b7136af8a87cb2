// How good an estimator of a vector is, from independent passes of it: mean, variance, bias, each with its own uncertainty.
#include "lab/estimate_statistics.h"

#include "base/student_t.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cmpg {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// A deviation counts as bias beyond these: an interval along the reference that leaves out 0 at this level, or this many standard
// errors anywhere. Where one direction dominates the variance the latter is (chi^2_1 - 1) / sqrt 2, which exceeds 5 with
// probability 0.5 %; with many directions it is normal and never does.
constexpr double kLevel = 0.001, kDeviations = 5;
// Single passes that miss rare bright paths are alike and all too dark, and surer of it than Student's t allows. Where one pass in 50 meets a path of 0.27, 29 of
// 2000 samples of 16 passes are called biased at the level above (tests/lab/estimate_statistics_test.cpp).
constexpr double kFewPassesLevel = 1e-5;
constexpr std::uint64_t kAveraged = 4; // passes of a batch, from which on it is taken for a mean of many
constexpr std::size_t kFewest = 4; // batches; fewer say nothing about their spread

template <class A, class B> double dot(const std::vector<A>& a, const std::vector<B>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += double(a[i]) * double(b[i]);
    return sum;
}

std::vector<std::vector<double>> products(const std::vector<std::vector<float>>& a, const std::vector<std::vector<float>>& b) {
    std::vector<std::vector<double>> result(a.size(), std::vector<double>(b.size()));
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t j = 0; j < b.size(); ++j)
            result[i][j] = dot(a[i], b[j]);
    return result;
}

// Mean over the pairs i != j of f(i, j).
template <class F> double offDiagonalMean(std::size_t n, F&& f) {
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            if (i != j)
                sum += f(i, j);
    return sum / (double(n) * double(n - 1));
}

struct SampleMoments {
    double mean = 0, meanVariance = 0, degrees = 0; // meanVariance: of the mean
};
SampleMoments momentsOf(const std::vector<double>& values) {
    SampleMoments m;
    const double n = double(values.size());
    for (const double v : values)
        m.mean += v / n;
    for (const double v : values)
        m.meanVariance += (v - m.mean) * (v - m.mean) / (n * (n - 1));
    m.degrees = n - 1;
    return m;
}

std::vector<double> projections(const std::vector<std::vector<float>>& batches, const Reference& reference) {
    std::vector<double> result;
    result.reserve(batches.size());
    for (const auto& batch : batches)
        result.push_back(dot(batch, reference.values) / reference.squaredNorm());
    return result;
}

void addAlong(Bias& bias, const EstimateStatistics& statistics, const Reference& reference) {
    // <r, r> exceeds what it estimates by the reference's own error.
    double inner = reference.variance;
    for (std::size_t i = 0; i < reference.values.size(); ++i)
        inner += (statistics.mean()[i] - reference.values[i]) * reference.values[i];
    bias.along = inner / reference.squaredNorm();
    const SampleMoments a = momentsOf(projections(statistics.batches(), reference));
    double variance = a.meanVariance, perDegree = a.meanVariance * a.meanVariance / a.degrees;
    if (reference.batches.size() >= kFewest) {
        const SampleMoments b = momentsOf(projections(reference.batches, reference));
        variance += b.meanVariance;
        perDegree += b.meanVariance * b.meanVariance / b.degrees;
    }
    bias.degrees = perDegree > 0 ? variance * variance / perDegree : a.degrees; // Welch and Satterthwaite
    bias.interval = studentQuantile(0.05, bias.degrees) * std::sqrt(variance);
}

// Around the reference's mean: the sums that follow cancel less then.
std::vector<std::vector<float>> centred(const std::vector<std::vector<float>>& batches, const Reference& reference) {
    std::vector<std::vector<float>> result = batches;
    for (auto& batch : result)
        for (std::size_t i = 0; i < batch.size(); ++i)
            batch[i] = float(double(batch[i]) - reference.values[i]);
    return result;
}

// tr(S^2) of the covariance S of vectors with these inner products: each pair around the mean of all others (Chen and Qin 2010, 3).
double squaredCovariance(const std::vector<std::vector<double>>& inner) {
    const std::size_t n = inner.size();
    std::vector<double> sums(n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            sums[i] += inner[i][j];
    const auto around = [&](auto i, auto j) { return inner[i][j] - (sums[j] - inner[i][j] - inner[j][j]) / double(n - 2); };
    return std::max(0.0, offDiagonalMean(n, [&](auto i, auto j) { return around(i, j) * around(j, i); }));
}

// tr(S T) of the covariances of two samples with these inner products.
double squaredCovariance(const std::vector<std::vector<double>>& inner, std::size_t n, std::size_t m) {
    std::vector<double> rows(n), columns(m);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < m; ++j) {
            rows[i] += inner[i][j];
            columns[j] += inner[i][j];
        }
    double sum = 0;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < m; ++j)
            sum += (inner[i][j] - (columns[j] - inner[i][j]) / double(n - 1)) * (inner[i][j] - (rows[i] - inner[i][j]) / double(m - 1));
    return std::max(0.0, sum / (double(n) * double(m)));
}

void addAnywhere(Bias& bias, const EstimateStatistics& statistics, const Reference& reference) {
    const auto x = centred(statistics.batches(), reference);
    const double n = double(x.size());
    const auto xx = products(x, x);
    bias.squared = offDiagonalMean(x.size(), [&](auto i, auto j) { return xx[i][j]; });
    double variance = 2 / (n * (n - 1)) * squaredCovariance(xx);
    if (reference.batches.size() >= kFewest) {
        const auto y = centred(reference.batches, reference);
        const double m = double(y.size());
        const auto yy = products(y, y), xy = products(x, y);
        bias.squared += offDiagonalMean(y.size(), [&](auto i, auto j) { return yy[i][j]; });
        for (const auto& row : xy)
            for (const double v : row)
                bias.squared -= 2 * v / (n * m);
        variance += 2 / (m * (m - 1)) * squaredCovariance(yy) + 4 / (n * m) * squaredCovariance(xy, x.size(), y.size());
    }
    bias.squared /= reference.squaredNorm();
    bias.squaredError = std::sqrt(variance) / reference.squaredNorm();
}

} // namespace

void EstimateStatistics::add(std::span<const double> pass) {
    ++passes_;
    const double k = double(passes_);
    double distance = 0;
    for (std::size_t i = 0; i < mean_.size(); ++i) {
        const double deviation = pass[i] - mean_[i];
        distance += deviation * deviation;
        mean_[i] += deviation / k;
        batch_[i] += pass[i];
    }
    if (passes_ > 1) {
        const double estimate = distance * (k - 1) / k;
        deviations_ += estimate;
        squaredDeviations_ += estimate * estimate;
    }
    if (++inBatch_ == batchSize_)
        closeBatch();
}

void EstimateStatistics::closeBatch() {
    std::vector<float> mean(batch_.size());
    for (std::size_t i = 0; i < mean.size(); ++i)
        mean[i] = float(batch_[i] / double(batchSize_));
    batches_.push_back(std::move(mean));
    std::fill(batch_.begin(), batch_.end(), 0.0);
    inBatch_ = 0;
    if (batches_.size() < kBatches)
        return;
    for (std::size_t b = 0; b < kBatches / 2; ++b) {
        auto& first = batches_[2 * b];
        const auto& second = batches_[2 * b + 1];
        for (std::size_t i = 0; i < first.size(); ++i)
            first[i] = 0.5f * (first[i] + second[i]);
        if (b > 0) // a vector must not be moved onto itself
            batches_[b] = std::move(first);
    }
    batches_.resize(kBatches / 2);
    batchSize_ *= 2;
}

Uncertain EstimateStatistics::variance() const {
    if (passes_ < 2)
        return {kNaN, kNaN};
    const double n = double(passes_ - 1), mean = deviations_ / n;
    if (passes_ < 3)
        return {mean, kNaN};
    return {mean, std::sqrt(std::max(0.0, squaredDeviations_ / n - mean * mean) / (n - 1))};
}

double Reference::squaredNorm() const {
    // Where noise exceeds the signal there is nothing to be relative to.
    const double norm = dot(values, values) - variance;
    return norm > 0 ? norm : kNaN;
}

Reference referenceOf(const EstimateStatistics& statistics) {
    return {statistics.mean(), statistics.batches(), statistics.meanVariance()};
}

double squaredDistance(std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

double meanSquaredError(std::span<const double> estimate, const Reference& reference) {
    return (squaredDistance(estimate, reference.values) - reference.variance) / double(estimate.size());
}

Bias biasOf(const EstimateStatistics& statistics, const Reference& reference) {
    Bias bias;
    if (statistics.batches().size() < kFewest || !(reference.squaredNorm() > 0)) {
        bias.along = bias.interval = bias.squared = bias.squaredError = kNaN;
        return bias;
    }
    addAlong(bias, statistics, reference);
    addAnywhere(bias, statistics, reference);
    const double error = bias.interval / studentQuantile(0.05, bias.degrees), level = statistics.batchSize() < kAveraged ? kFewPassesLevel : kLevel;
    const bool along = error > 0 ? !(studentTwoSided(bias.along / error, bias.degrees) >= level) : bias.along != 0; // what is no number is no proof
    // The interval has the reference's error in this direction in it. Anywhere, that error is at most its share of all directions.
    if (along)
        bias.verdict = Bias::Verdict::Biased;
    else if (bias.z() > kDeviations)
        bias.verdict = bias.squared < reference.relativeError() ? Bias::Verdict::BelowReference : Bias::Verdict::Biased;
    return bias;
}

} // namespace cmpg

// How good an estimator of a vector is, from independent passes of it: mean, variance, bias, each with its own uncertainty.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace cmpg {

// A number and its standard error.
struct Uncertain {
    double value = 0, error = 0;
};

// Takes passes one by one; keeps the mean of all, the variance of one, and at most kBatches means of consecutive passes.
class EstimateStatistics {
  public:
    static constexpr std::size_t kBatches = 32;

    explicit EstimateStatistics(std::size_t entries) : mean_(entries), batch_(entries) {}

    void add(std::span<const double> pass);

    std::uint64_t passes() const { return passes_; }
    const std::vector<double>& mean() const { return mean_; }
    // Of one pass, summed over the entries. Unbiased; its error is the spread of |x_k - mean of the earlier passes|^2, whose
    // expectations are the variance times k / (k - 1).
    Uncertain variance() const;
    // Squared standard error of the mean, summed over the entries.
    double meanVariance() const { return passes_ > 0 ? variance().value / double(passes_) : 0; }
    // Means of equally many consecutive passes each; passes left over are not among them. At least kBatches / 2 once that many
    // passes were added.
    const std::vector<std::vector<float>>& batches() const { return batches_; }
    std::uint64_t batchSize() const { return batchSize_; } // passes of a batch

  private:
    void closeBatch();

    std::uint64_t passes_ = 0;
    std::vector<double> mean_;
    double deviations_ = 0, squaredDeviations_ = 0; // sums over the passes but the first, see variance()
    std::uint64_t batchSize_ = 1, inBatch_ = 0;
    std::vector<double> batch_; // sum over the passes of the batch being filled
    std::vector<std::vector<float>> batches_;
};

// What estimates are compared with. Its own error is known where it was averaged here, and unknown where it is a given file.
struct Reference {
    std::vector<double> values;
    std::vector<std::vector<float>> batches; // of EstimateStatistics; empty: a file
    double variance = 0;                     // squared standard error, summed over the entries

    double squaredNorm() const; // of the truth: without what its own error adds
    double relativeError() const { return variance / squaredNorm(); } // ||standard error||^2 / ||truth||^2
};
Reference referenceOf(const EstimateStatistics& statistics);

double squaredDistance(std::span<const double> a, std::span<const double> b);
// Over the entries, against the truth: what the reference's own error adds is taken off. Unbiased, so it may come out negative where the
// reference is no better than the estimate.
double meanSquaredError(std::span<const double> estimate, const Reference& reference);

struct Bias {
    // Along the reference: <mean - reference, reference> / |reference|^2; 0.01: one percent too large as a whole. `interval` is half
    // the width of the 95 % interval by Student's t, the reference's own error included.
    double along = 0, interval = 0, degrees = 0;
    // Anywhere: unbiased estimate of |E mean - E reference|^2 / |reference|^2 (may come out negative), its standard error if there
    // were no bias, and their ratio. Two-sample statistic of Chen and Qin 2010, for vectors longer than there are samples.
    double squared = 0, squaredError = 0;
    double z() const { return squaredError > 0 ? squared / squaredError : 0; }

    enum class Verdict {
        None,           // none seen
        BelowReference, // a deviation in some direction, no larger than the error of the reference as a whole
        Biased,
    } verdict = Verdict::None;
};
Bias biasOf(const EstimateStatistics& statistics, const Reference& reference);

} // namespace cmpg

// What texels that no image tells are likely to be, from those that images tell.
#include "optimize/texture_guess.h"

#include "optimize/entry_loops.h"
#include "optimize/fourier.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

namespace cmpg {
namespace {

constexpr std::size_t kMostAtOnce = 128 * 128;          // beyond, a coarser grid does: transforms would take as long as a step
constexpr std::size_t kFewestTold = 256;                // or there is no covariance to be learned
constexpr double kLeastTold = 0.1, kMostTold = 0.98;    // of all texels
constexpr double kFewPairs = 20;                        // of texels at a distance: so many without covariance are added
constexpr double kNoiseShare = 0.03;                         // of the variance: told texels have errors, and no texture repeats exactly
constexpr double kFadingReach = 0.5;                          // of the texture's size: standard deviation of the Gaussian that covariances are faded by
constexpr std::size_t kMostTrials = 3;                      // of a guess, on told texels that are left out
constexpr double kMostOut = 0.5;                        // of told texels
constexpr double kBetter = 0.95;                        // of a smooth surface's squared error, at most
constexpr int kIterations = 40, kSmoothIterations = 400;
constexpr double kResidual = 1e-3; // of the residual's norm

double product(const std::vector<float>& a, const std::vector<float>& b) {
    return sumOfEntries(a.size(), [&](std::size_t i) { return double(a[i]) * b[i]; });
}

// x with A x = b, from 0, by conjugate gradients.
template <class Multiply> std::vector<float> solve(const Multiply& multiply, std::vector<float> residual, int iterations) {
    std::vector<float> x(residual.size()), direction = residual;
    double length = product(residual, residual);
    const double enough = length * kResidual * kResidual;
    for (int k = 0; k < iterations && length > enough; ++k) {
        const std::vector<float> image = multiply(direction);
        const double curvature = product(direction, image);
        if (!(curvature > 0))
            break;
        const auto step = float(length / curvature);
        for (std::size_t i = 0; i < x.size(); ++i) {
            x[i] += step * direction[i];
            residual[i] -= step * image[i];
        }
        const double next = product(residual, residual);
        const auto turn = float(next / length);
        for (std::size_t i = 0; i < x.size(); ++i)
            direction[i] = residual[i] + turn * direction[i];
        length = next;
    }
    return x;
}

void leaveOut(const std::vector<bool>& told, std::size_t channels, std::vector<float>& values) {
    for (std::size_t t = 0; t < told.size(); ++t)
        if (!told[t])
            std::fill_n(values.begin() + std::ptrdiff_t(t * channels), channels, 0.f);
}

// Means of the channels over told texels, and what these differ from them; 0 elsewhere.
struct Differences {
    std::vector<double> mean;
    std::vector<float> values;

    Differences(std::span<const float> all, const std::vector<bool>& told, std::size_t channels) : mean(channels), values(all.begin(), all.end()) {
        const auto count = double(std::count(told.begin(), told.end(), true));
        for (std::size_t i = 0; i < all.size(); ++i)
            mean[i % channels] += told[i / channels] ? all[i] / count : 0;
        for (std::size_t i = 0; i < all.size(); ++i)
            values[i] -= float(mean[i % channels]);
        leaveOut(told, channels, values);
    }
};

// The covariance of texels by their distance, of all channels alike.
class Covariance {
  public:
    Covariance(const TextureGrid& grid, const std::vector<float>& differences, const std::vector<bool>& told)
        : grid_(grid), width_(std::bit_ceil(2 * grid.width)), height_(std::bit_ceil(2 * grid.height)) {
        std::vector<double> sums(width_ * height_), pairs(sums.size());
        forPlanes([&](std::size_t first) { addProducts(planeOf(differences, first), sums); });
        FourierPlane mask(width_, height_);
        for (std::size_t t = 0; t < told.size(); ++t)
            mask.real[t / grid.width * width_ + t % grid.width] = told[t] ? 1.f : 0.f;
        addProducts(std::move(mask), pairs);
        fold(sums);
        fold(pairs);
        variance_ = pairs[0] > 0 ? sums[0] / pairs[0] / double(grid.channels) : 0;
        // Far covariances come from few pairs, and fade. What of their spectrum is negative, which no covariance has, is left out.
        FourierPlane plane(width_, height_);
        for (std::size_t y = 0; y < height_; ++y)
            for (std::size_t x = 0; x < width_; ++x) {
                const std::size_t i = y * width_ + x;
                const double across = double(std::min(x, width_ - x)) / (kFadingReach * double(grid.width)), down = double(std::min(y, height_ - y)) / (kFadingReach * double(grid.height));
                plane.real[i] = float(sums[i] / (pairs[i] + kFewPairs) * std::exp(-0.5 * (across * across + down * down)));
            }
        plane.transform();
        spectrum_ = std::move(plane.real);
        double sum = 0;
        for (float& value : spectrum_) {
            value = std::max(0.f, value);
            sum += value;
        }
        const auto scale = float(sum > 0 ? variance_ / sum : 0); // at no distance the variance, with the factor that an inverse transform leaves out
        for (float& value : spectrum_)
            value *= scale;
    }

    double variance() const { return variance_; }

    // C x over the grid.
    std::vector<float> multiply(const std::vector<float>& x) const {
        std::vector<float> out(x.size());
        forPlanes([&](std::size_t first) {
            FourierPlane plane = planeOf(x, first);
            plane.transform();
            for (std::size_t i = 0; i < spectrum_.size(); ++i) {
                plane.real[i] *= spectrum_[i];
                plane.imaginary[i] *= spectrum_[i];
            }
            plane.invert();
            for (std::size_t t = 0; t < grid_.width * grid_.height; ++t) {
                const std::size_t at = t / grid_.width * width_ + t % grid_.width;
                out[t * grid_.channels + first] = plane.real[at];
                if (first + 1 < grid_.channels)
                    out[t * grid_.channels + first + 1] = plane.imaginary[at];
            }
        });
        return out;
    }

  private:
    // Two channels at a time, as real and imaginary part.
    template <class Use> void forPlanes(const Use& use) const {
        for (std::size_t first = 0; first < grid_.channels; first += 2)
            use(first);
    }

    FourierPlane planeOf(const std::vector<float>& x, std::size_t first) const {
        FourierPlane plane(width_, height_);
        for (std::size_t t = 0; t < grid_.width * grid_.height; ++t) {
            const std::size_t at = t / grid_.width * width_ + t % grid_.width;
            plane.real[at] = x[t * grid_.channels + first];
            plane.imaginary[at] = first + 1 < grid_.channels ? x[t * grid_.channels + first + 1] : 0.f;
        }
        return plane;
    }

    // Adds the sum of products of all pairs at each distance.
    static void addProducts(FourierPlane plane, std::vector<double>& sums) {
        plane.transform();
        for (std::size_t i = 0; i < plane.real.size(); ++i) {
            plane.real[i] = plane.real[i] * plane.real[i] + plane.imaginary[i] * plane.imaginary[i];
            plane.imaginary[i] = 0;
        }
        plane.invert();
        for (std::size_t i = 0; i < sums.size(); ++i)
            sums[i] += double(plane.real[i]) / double(sums.size());
    }

    // Few pairs tell more where mirrored textures are taken for as likely, and of square ones those that are turned.
    void fold(std::vector<double>& sums) const {
        const std::vector<double> given = sums;
        for (std::size_t y = 0; y < height_; ++y)
            for (std::size_t x = 0; x < width_; ++x)
                sums[y * width_ + x] += given[y * width_ + (width_ - x) % width_];
        if (grid_.width != grid_.height)
            return;
        const std::vector<double> mirrored = sums;
        for (std::size_t y = 0; y < height_; ++y)
            for (std::size_t x = 0; x < width_; ++x)
                sums[y * width_ + x] += mirrored[x * width_ + y];
    }

    TextureGrid grid_;
    std::size_t width_, height_; // twice the grid's, so that nothing meets itself around the edges
    std::vector<float> spectrum_; // transposed, as transforms leave it
    double variance_ = 0;
};

std::vector<float> krige(const Covariance& covariance, const Differences& known, const std::vector<bool>& told, std::size_t channels) {
    const auto noise = float(kNoiseShare * covariance.variance());
    const std::vector<float> weights = solve(
        [&](const std::vector<float>& x) {
            std::vector<float> image = covariance.multiply(x);
            for (std::size_t i = 0; i < x.size(); ++i)
                image[i] += noise * x[i];
            leaveOut(told, channels, image);
            return image;
        },
        known.values, kIterations);
    std::vector<float> guess = covariance.multiply(weights);
    for (std::size_t i = 0; i < guess.size(); ++i)
        guess[i] += float(known.mean[i % channels]);
    return guess;
}

// The surface through the told texels that has the least squared differences of neighbours.
std::vector<float> smoothSurface(const TextureGrid& grid, const Differences& known, const std::vector<bool>& told) {
    const std::size_t row = grid.width * grid.channels;
    const auto laplacian = [&](const std::vector<float>& x) {
        std::vector<float> out(x.size());
        const auto pair = [&](std::size_t i, std::size_t j) {
            const float d = x[i] - x[j];
            out[i] += d;
            out[j] -= d;
        };
        for (std::size_t y = 0; y < grid.height; ++y)
            for (std::size_t i = y * row; i < (y + 1) * row; ++i) {
                if (i + grid.channels < (y + 1) * row)
                    pair(i, i + grid.channels);
                else if (grid.wrapU)
                    pair(i, i + grid.channels - row);
                if (y + 1 < grid.height)
                    pair(i, i + row);
                else if (grid.wrapV)
                    pair(i, i % row);
            }
        return out;
    };
    std::vector<bool> untold = told;
    untold.flip();
    std::vector<float> right = laplacian(known.values);
    for (float& value : right)
        value = -value;
    leaveOut(untold, grid.channels, right);
    std::vector<float> surface = solve(
        [&](const std::vector<float>& x) {
            std::vector<float> image = laplacian(x);
            leaveOut(untold, grid.channels, image);
            return image;
        },
        std::move(right), kSmoothIterations);
    for (std::size_t i = 0; i < surface.size(); ++i)
        surface[i] += known.values[i] + float(known.mean[i % grid.channels]);
    return surface;
}

// Told texels to try a guess on: where the untold ones would be if the texture were moved, so that gaps are as wide as they are. Those of the moves that leave out
// most, of which half of the told ones may be left out.
std::vector<std::vector<bool>> leftOut(const TextureGrid& grid, const std::vector<bool>& told) {
    constexpr std::size_t kMoves = 4; // along a side
    const double most = kMostOut * double(std::count(told.begin(), told.end(), true));
    std::vector<std::pair<std::ptrdiff_t, std::vector<bool>>> found;
    for (std::size_t move = 1; move < kMoves * kMoves; ++move) {
        const std::size_t across = move % kMoves * grid.width / kMoves, down = move / kMoves * grid.height / kMoves;
        std::vector<bool> out(told.size());
        for (std::size_t t = 0; t < told.size(); ++t) {
            const std::size_t from = (t / grid.width + down) % grid.height * grid.width + (t % grid.width + across) % grid.width;
            out[t] = told[t] && !told[from];
        }
        const std::ptrdiff_t count = std::count(out.begin(), out.end(), true);
        if (count > 0 && double(count) <= most)
            found.emplace_back(count, std::move(out));
    }
    std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<std::vector<bool>> trials;
    for (std::size_t i = 0; i < std::min(kMostTrials, found.size()); ++i)
        trials.push_back(std::move(found[i].second));
    return trials;
}

double squaredError(const std::vector<float>& guess, std::span<const float> values, const std::vector<bool>& at, std::size_t channels) {
    double sum = 0;
    for (std::size_t i = 0; i < guess.size(); ++i)
        if (at[i / channels])
            sum += (double(guess[i]) - values[i]) * (double(guess[i]) - values[i]);
    return sum;
}

std::optional<std::vector<float>> guessCoarser(const TextureGrid& grid, std::span<const float> values, const std::vector<bool>& told) {
    const CoarseTexture texture(grid);
    std::vector<float> weights(grid.entries()), known(values.begin(), values.end());
    for (std::size_t i = 0; i < weights.size(); ++i)
        weights[i] = told[i / grid.channels] ? 1.f : 0.f;
    leaveOut(told, grid.channels, known);
    std::vector<float> coarse = texture.gather(known);
    const std::vector<float> sums = texture.gather(weights), whole = texture.gather(std::vector<float>(grid.entries(), 1.f));
    std::vector<bool> toldCoarse(coarse.size() / grid.channels);
    for (std::size_t i = 0; i < coarse.size(); ++i) {
        coarse[i] = sums[i] > 0 ? coarse[i] / sums[i] : 0;
        toldCoarse[i / grid.channels] = 2 * sums[i] > whole[i];
    }
    const std::optional<std::vector<float>> guess = guessTexture(texture.coarse(), coarse, toldCoarse);
    if (!guess)
        return guess;
    std::vector<float> finer(grid.entries());
    texture.spread(*guess, finer);
    return finer;
}

} // namespace

std::optional<std::vector<float>> guessTexture(const TextureGrid& grid, std::span<const float> values, const std::vector<bool>& told) {
    const std::size_t count = told.size();
    const auto known = std::size_t(std::count(told.begin(), told.end(), true));
    if (known < kFewestTold || double(known) < kLeastTold * double(count) || double(known) > kMostTold * double(count))
        return std::nullopt;
    if (count > kMostAtOnce)
        return guessCoarser(grid, values, told);

    const std::vector<std::vector<bool>> trials = leftOut(grid, told);
    std::vector<double> smooth(trials.size()), guessed(trials.size()); // squared errors
    std::vector<float> guess;
    parallelFor(trials.size() + 1, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            std::vector<bool> rest = told;
            for (std::size_t t = 0; i < trials.size() && t < count; ++t)
                rest[t] = told[t] && !trials[i][t];
            const Differences differences(values, rest, grid.channels);
            std::vector<float> found = krige(Covariance(grid, differences.values, rest), differences, rest, grid.channels);
            if (i == trials.size()) {
                guess = std::move(found);
                continue;
            }
            guessed[i] = squaredError(found, values, trials[i], grid.channels);
            smooth[i] = squaredError(smoothSurface(grid, differences, rest), values, trials[i], grid.channels);
        }
    });
    if (!(std::accumulate(guessed.begin(), guessed.end(), 0.0) < kBetter * std::accumulate(smooth.begin(), smooth.end(), 0.0)))
        return std::nullopt; // also where no trial can be made
    return guess;
}

} // namespace cmpg

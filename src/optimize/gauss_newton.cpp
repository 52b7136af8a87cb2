// Gauss-Newton steps of textures, coarse to fine.
#include "optimize/gauss_newton.h"

#include "optimize/entry_loops.h"
#include "optimize/texture_curvature.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cmpg {
namespace {

// Momentum of entries whose last step goes against this one's, and of others where the gradient is all signal: what images hardly tell, such as texels
// finer than a pixel, goes a small part of the distance in a step of a diagonal, always in one direction. Noise goes back and forth.
struct Momentum {
    float least, most;
    float steps; // over which it begins
};
constexpr Momentum kMomentum{0.5f, 0.75f, 1};
// Where what single texels do is known, the first steps go the whole distance, and momentum would go beyond it.
constexpr Momentum kSeenMomentum{0.25f, 0.6f, 5};
// The share of noise in a gradient with which the shape of lobes has no momentum: its texels wander with what noise moved. Normals do better with it.
constexpr float kTooNoisy = 0.25f;
constexpr double kLeastShare = 0.02; // of the signal: the average may be below 0 by chance

// A gradient as one of the grids sees it, and what bounds the curvature there.
struct Grid {
    const TotalVariationBound& known;
    SeenPart seen;
    std::span<const float> diagonal;      // D
    std::span<const float> gradient, half; // as in NoisyGradient
    std::span<const float> scale; // of the rate, by entry; empty: 1

    // The step that `left` of the gradient asks for, times the share of the signal in all of it. `noise`: what the grid's texels remember.
    std::vector<float> step(std::vector<float> left, SignalNoise& noise, double rate, bool first) const {
        const std::size_t count = gradient.size();
        const double weight = first ? 1 : kLatestWeight;
        std::vector<float> deviation = followNoise(noise.squares, half, float(weight));
        if (!scale.empty())
            forEachEntry(count, [&](std::size_t i) { deviation[i] /= scale[i]; });
        const TextureCurvature curvature(known, seen, diagonal, std::move(deviation), float(std::min(rate, 1e30)));
        noise.follow(curvature.length(gradient), curvature.length(half), weight);
        std::vector<float> result = curvature.solve(std::move(left));
        const auto share = float(signalShare(noise));
        forEachEntry(count, [&](std::size_t i) { result[i] *= share; });
        return result;
    }
};

// What a step of texels of one grid together is solved with.
class CoarseGrid {
  public:
    CoarseGrid(const Grid& finer, const CoarseTexture& texture)
        : texture_(texture), known_(finer.known.coarser(texture)), diagonal_(texture.gather(finer.diagonal)), gradient_(texture.gather(finer.gradient)),
          half_(texture.gather(finer.half)), scale_(texture.meanOf(finer.scale)) {}

    const CoarseTexture& texture() const { return texture_; } // from the next finer grid
    Grid grid(const SeenPart& seen = {}) const { return {known_, seen, diagonal_, gradient_, half_, scale_}; }

  private:
    CoarseTexture texture_;
    TotalVariationBound known_;
    std::vector<float> diagonal_, gradient_, half_, scale_;
};

// The sum of steps on ever finer grids, the last on `finest`. `noise`: of that one, then of ever coarser ones.
std::vector<float> stepsOfGrids(const Grid& finest, std::span<SignalNoise> noise, double rate, bool first) {
    const std::size_t count = finest.gradient.size();
    std::vector<float> step(count), left(finest.gradient.begin(), finest.gradient.end());
    if (noise.size() > 1) {
        const CoarseGrid coarse(finest, CoarseTexture(finest.known.grid()));
        coarse.texture().spread(stepsOfGrids(coarse.grid(), noise.subspan(1), rate, first), step);
        finest.known.multiply(finest.diagonal, step, left); // of a smooth step C makes what the sums of its rows make
        forEachEntry(count, [&](std::size_t i) { left[i] = finest.gradient[i] - left[i]; });
    }
    const std::vector<float> fine = finest.step(std::move(left), noise[0], rate, first);
    forEachEntry(count, [&](std::size_t i) { step[i] += fine[i]; });
    return step;
}

float boundOf(double product, float direction) {
    const double found = product / double(direction);
    return found > 0 && found < std::numeric_limits<float>::max() ? float(found) : 0.f; // noise, or a path that overflowed
}

// A diagonal that bounds the curvature of the loss of some views, whichever they are: a view weighs at most 1 / share times as much as among all.
std::vector<float> boundOfSome(const Moments& moments, double share) {
    std::vector<float> bound(moments.second.size());
    forEachEntry(bound.size(), [&](std::size_t i) { bound[i] = std::min(moments.peak[i], float(moments.second[i] / share)); });
    return bound;
}

} // namespace

double reachOf(SlotKind kind, double rate) {
    constexpr double kLinear = 0.04; // where images are far from linear: farther steps end where they began or worse
    const double reach = std::min(kNewtonReach * rate, 1e30);
    return isFarFromLinear(kind) ? std::min(reach, kLinear) : reach;
}

std::size_t countOfGrids(const TotalVariationBound& known) {
    if (known.empty())
        return 1;
    std::size_t count = 1;
    for (TextureGrid grid = known.grid(); grid.width * grid.height > 1; grid = grid.coarser())
        ++count;
    return count;
}

std::vector<float> followNoise(std::vector<float>& squares, std::span<const float> half, float weight) {
    std::vector<float> deviation(half.size());
    squares.resize(half.size());
    forEachEntry(half.size(), [&](std::size_t i) {
        const float square = half[i] * half[i];
        float& average = squares[i];
        average += weight * (square - average);
        deviation[i] = std::sqrt(std::max(average, square));
    });
    return deviation;
}

double signalShare(const SignalNoise& noise) {
    const double whole = noise.signal + noise.noise;
    return whole > 0 ? std::clamp(noise.signal / whole, kLeastShare, 1.0) : 1;
}

void addCurvature(std::span<const double> product, const CurvatureDirection& direction, Moments& moments) {
    const bool only = moments.products++ == 0 || !direction.light.empty();
    moments.peak = {};
    forEachEntry(product.size(), [&](std::size_t i) {
        const float bound = boundOf(product[i], direction[i]);
        moments.second[i] = only ? bound : 0.5f * (moments.second[i] + bound);
    });
}

void addCurvature(std::span<const double> part, std::span<const double> largest, const CurvatureDirection& direction, double share, Moments& moments) {
    moments.peak.resize(part.size());
    // What was measured before fades while all views are measured anew. The largest by no more than 0.6, until its view's turn comes: steps stay below twice
    // as long as they should be.
    const float mean = float(1 - share), peak = float(1 - 0.5 * share);
    forEachEntry(part.size(), [&](std::size_t i) {
        moments.second[i] = mean * moments.second[i] + boundOf(part[i], direction[i]);
        moments.peak[i] = std::max(peak * moments.peak[i], boundOf(largest[i], direction[i]));
    });
}

std::uint64_t updateByGaussNewton(double rate, NoisyGradient gradient, const TotalVariationBound& known, Moments& moments, Parameter& parameter, double lightUnit,
                                  const CoarseTexture* coarse) {
    const std::size_t count = parameter.entries();
    std::vector<float> g(count);
    const auto skipped = orderedSum<std::uint64_t>(count, kEntriesAtOnce, [&](std::size_t begin, std::size_t end) {
        std::uint64_t sum = 0;
        for (std::size_t i = begin; i < end; ++i) {
            g[i] = usableOrZero(gradient.mean[i]);
            sum += !isUsable(float(gradient.mean[i]));
        }
        return sum;
    });
    std::vector<float> half(count);
    forEachEntry(count, [&](std::size_t i) { half[i] = usableOrZero(gradient.half[i]); });
    gradient.half = std::vector<double>(); // before the solver takes memory
    std::vector<float> scale;
    if (lightUnit > 0) {
        scale.resize(count);
        forEachEntry(count, [&](std::size_t i) { scale[i] = std::max(1.f, float(parameter.values[i] / lightUnit)); });
    }
    const bool first = moments.steps++ == 0;
    const bool some = gradient.viewShare < 1 && !moments.peak.empty();
    const std::vector<float> own = some ? boundOfSome(moments, gradient.viewShare) : std::vector<float>();
    const std::span<const float> diagonal = some ? own : moments.second;
    const auto signal = float(signalShare(moments.noise[0]));
    const SeenPart seen = some ? SeenPart() : SeenPart{moments.seen.get(), signal * signal};
    const auto stepsOn = [&](const Grid& finest) {
        moments.noise.resize(countOfGrids(finest.known));
        return stepsOfGrids(finest, moments.noise, rate, first);
    };
    std::vector<float> step;
    if (coarse) {
        step.resize(count);
        const CoarseGrid grid(Grid{known, {}, diagonal, g, half, scale}, *coarse);
        coarse->spread(stepsOn(grid.grid(seen)), step);
    } else
        step = stepsOn(Grid{known, seen, diagonal, g, half, scale});
    const auto share = float(signalShare(moments.noise[0]));
    const float reach = float(reachOf(parameter.kind, rate)), lowest = parameter.lowest(), highest = std::min(parameter.highest(), kLargestValue);
    float* values = parameter.values.data();
    float* velocity = moments.first.data();
    // What one view sees alone would go on in the steps of others.
    const Momentum& momentum = seen.texels ? kSeenMomentum : kMomentum;
    const float quiet = shapesLobe(parameter.kind) ? std::max(0.f, 1 - (1 - share) / kTooNoisy) : 1.f;
    const float ramp = quiet * std::min(1.f, float(moments.steps - 1) / momentum.steps);
    const float least = some ? 0 : ramp * momentum.least, along = some ? 0 : ramp * (momentum.least + (momentum.most - momentum.least) * share);
    forEachEntry(count, [&](std::size_t i) {
        const float wanted = (velocity[i] * step[i] < 0 ? along : least) * velocity[i] - step[i];
        const float most = scale.empty() ? reach : std::min(reach * scale[i], std::numeric_limits<float>::max());
        const float moved = std::clamp(values[i] + (wanted == wanted ? std::clamp(wanted, -most, most) : 0.f), lowest, highest);
        velocity[i] = moved - values[i];
        values[i] = moved;
    });
    return skipped;
}

} // namespace cmpg

// Gauss-Newton steps of several maps of one material together, coarse to fine.
#include "optimize/coupled_maps.h"

#include "optimize/entry_loops.h"
#include "optimize/gauss_newton.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace cmpg {
namespace {

// As kMomentum of single maps, whose steps of a diagonal reach less far.
constexpr float kLeastMomentum = 0.25f, kMostMomentum = 0.5f;
constexpr double kDamping = 8; // times the residual
// Of what a lobe's shape is, it falls by no more in a step: near 0 images hardly answer to it, and it would stay there.
constexpr float kShapeFalls = 0.2f, kLeastFall = 0.01f;

// The part of a map's range over which images are about linear in it.
double linearPart(const Parameter& parameter) {
    if (parameter.kind == SlotKind::Normal)
        return 0.3;
    if (shapesLobe(parameter.kind))
        return 0.1;
    return parameter.channels == 1 ? 0.2 : 0.5;
}

// All maps on a coarser grid.
class CoarseMaps {
  public:
    explicit CoarseMaps(const MapsOnGrid& finer, std::size_t factor = 4) {
        for (std::size_t m = 0; m < finer.maps.size(); ++m) {
            textures_.emplace_back(finer.maps[m].known->grid(), factor);
            known_.push_back(finer.maps[m].known->coarser(textures_.back()));
        }
        for (std::size_t m = 0; m < finer.maps.size(); ++m) {
            maps_.maps.push_back(finer.maps[m]);
            maps_.maps.back().known = &known_[m];
            maps_.maps.back().entry = maps_.diagonal.size();
            maps_.maps.back().damping *= double(finer.texels()) / double(known_[m].grid().width * known_[m].grid().height);
            append(finer, m, finer.diagonal, maps_.diagonal);
            append(finer, m, finer.gradient, maps_.gradient);
            append(finer, m, finer.half, maps_.half);
        }
        if (!finer.cross.below.empty()) {
            TextureGrid grid = finer.maps[0].known->grid();
            grid.channels = CrossCurvature::count(finer.block());
            maps_.cross.below = CoarseTexture(grid, factor).gather(finer.cross.below);
        }
    }

    MapsOnGrid& maps() { return maps_; }
    void spread(const MapsOnGrid& finer, std::span<const float> coarse, std::span<float> x) const {
        for (std::size_t m = 0; m < textures_.size(); ++m)
            textures_[m].spread(coarse.subspan(maps_.maps[m].entry, maps_.entries(m)), x.subspan(finer.maps[m].entry, finer.entries(m)));
    }

  private:
    void append(const MapsOnGrid& finer, std::size_t m, const std::vector<float>& from, std::vector<float>& to) const {
        const std::vector<float> part = textures_[m].gather(std::span(from).subspan(finer.maps[m].entry, finer.entries(m)));
        to.insert(to.end(), part.begin(), part.end());
    }

    std::vector<CoarseTexture> textures_; // from the next finer grid
    std::vector<TotalVariationBound> known_;
    MapsOnGrid maps_;
};

// The first map's moments have signal and noise of all.
class CoupledSteps {
  public:
    // `weight`: of this step's gradient in what the moments know of noise.
    CoupledSteps(std::span<CoupledMap> maps, double weight) : maps_(maps), weight_(weight) {}

    // The sum of steps on ever finer grids, the last on `finest`, which is the `level`th from the maps' own.
    std::vector<float> of(MapsOnGrid& finest, std::size_t level) {
        std::vector<float> step(finest.gradient.size()), left = finest.gradient;
        if (level + 1 < maps_[0].moments.noise.size()) {
            CoarseMaps coarse(finest);
            coarse.spread(finest, of(coarse.maps(), level + 1), step);
            finest.multiply(step, left);
            forEachEntry(left.size(), [&](std::size_t i) { left[i] = finest.gradient[i] - left[i]; });
        }
        const std::vector<float> fine = alone(finest, std::move(left), level);
        forEachEntry(step.size(), [&](std::size_t i) { step[i] += fine[i]; });
        return step;
    }

  private:
    std::vector<float> alone(MapsOnGrid& grid, std::vector<float> left, std::size_t level) {
        std::vector<float> deviation;
        for (std::size_t m = 0; m < maps_.size(); ++m) {
            const std::vector<float> part =
                followNoise(maps_[m].moments.noise[level].squares, std::span(grid.half).subspan(grid.maps[m].entry, grid.entries(m)), float(weight_));
            deviation.insert(deviation.end(), part.begin(), part.end());
        }
        const BlockCurvature curvature(grid, deviation);
        SignalNoise& noise = maps_[0].moments.noise[level];
        noise.follow(curvature.length(grid.gradient), curvature.length(grid.half), weight_);
        std::vector<float> result = curvature.solve(std::move(left));
        const auto share = float(signalShare(noise));
        forEachEntry(result.size(), [&](std::size_t i) { result[i] *= share; });
        return result;
    }

    std::span<CoupledMap> maps_;
    double weight_;
};

// What is to be solved on the maps' own grid, with nothing that leads `held` entries on; returns how many entries of a gradient are not finite.
std::uint64_t fill(std::span<const CoupledMap> maps, const CrossCurvature& cross, double residual, double viewShare, std::span<const std::uint8_t> held, MapsOnGrid& grid) {
    std::uint64_t skipped = 0;
    std::size_t entries = 0, place = 0;
    for (const CoupledMap& map : maps) {
        const std::size_t texels = std::size_t(map.parameter.width) * map.parameter.height;
        const double part = linearPart(map.parameter);
        grid.maps.push_back({&map.known, entries, place, kDamping * std::max(0.0, residual) / double(texels) / (part * part), map.rate});
        entries += map.parameter.entries();
        place += map.parameter.channels;
    }
    grid.diagonal.resize(entries);
    grid.gradient.resize(entries);
    grid.half.resize(entries);
    std::vector<float> ties(entries); // how far an entry's curvature with others is that of the whole
    for (std::size_t m = 0; m < maps.size(); ++m) {
        const CoupledMap& map = maps[m];
        const std::size_t first = grid.maps[m].entry;
        skipped += orderedSum<std::uint64_t>(map.parameter.entries(), kEntriesAtOnce, [&](std::size_t begin, std::size_t end) {
            std::uint64_t sum = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const float whole = float(map.moments.second[i] / viewShare);
                sum += !isUsable(float(map.gradient[i]));
                // Of the mean over all views, what bounds whichever of them a step sees; of an entry that few of them see less.
                const float own = viewShare < 1 && !map.moments.peak.empty() ? std::min(map.moments.peak[i], whole) : whole;
                grid.diagonal[first + i] = own;
                grid.gradient[first + i] = held[first + i] ? 0.f : usableOrZero(map.gradient[i]);
                grid.half[first + i] = held[first + i] ? 0.f : usableOrZero(map.half[i]);
                ties[first + i] = held[first + i] || !(whole > 0) ? 0.f : std::sqrt(own / whole);
            }
            return sum;
        });
    }
    if (cross.below.empty())
        return skipped;
    grid.cross = cross;
    const std::size_t block = grid.block();
    forEachEntry(grid.texels(), [&](std::size_t t) {
        std::array<float, BlockCurvature::kMostEntries> of{};
        for (std::size_t m = 0; m < maps.size(); ++m)
            for (std::size_t c = 0; c < grid.channels(m); ++c)
                of[grid.maps[m].place + c] = ties[grid.maps[m].entry + t * grid.channels(m) + c];
        float* below = grid.cross.below.data() + t * CrossCurvature::count(block);
        for (std::size_t row = 1; row < block; ++row)
            for (std::size_t column = 0; column < row; ++column)
                *below++ *= float(of[row] * of[column] / viewShare);
    });
    return skipped;
}

// How far an entry may go from `value` in a step along `wanted`.
float reachFrom(SlotKind kind, float value, float wanted, double rate) {
    const auto reach = float(reachOf(kind, rate));
    return shapesLobe(kind) && wanted < 0 ? std::min(reach, std::max(kLeastFall, kShapeFalls * value)) : reach;
}

// Holds what is at the end of its range and would leave it by `step`; returns whether there is any that was not held.
bool hold(std::span<const CoupledMap> maps, std::span<const float> step, std::span<std::uint8_t> held) {
    bool more = false;
    std::size_t entry = 0;
    for (const CoupledMap& map : maps) {
        const float lowest = map.lowest(), highest = map.parameter.highest();
        for (const float value : map.parameter.values) {
            const bool leaves = (value <= lowest && step[entry] > 0) || (value >= highest && step[entry] < 0);
            more = more || (leaves && !held[entry]);
            held[entry] = held[entry] || leaves;
            ++entry;
        }
    }
    return more;
}

// Adds to the values of texel t what is wanted of them, cut as a whole.
template <class Wanted> void moveTexel(std::span<CoupledMap> maps, std::size_t t, const Wanted& wanted) {
    constexpr float kLeastCut = 0.25f; // where an entry comes to the end of its range: it stops there, and the others go on
    float times = 1, inRange = 1;
    for (std::size_t m = 0; m < maps.size(); ++m) {
        const Parameter& parameter = maps[m].parameter;
        for (std::size_t i = t * parameter.channels; i < (t + 1) * parameter.channels; ++i) {
            const float value = parameter.values[i], far = wanted(m, i), length = std::abs(far), reach = reachFrom(parameter.kind, value, far, maps[m].rate);
            const float within = far < 0 ? value - maps[m].lowest() : parameter.highest() - value;
            times = length * times > reach ? reach / length : times;
            if (within > 0) // else it is held
                inRange = length * inRange > within ? within / length : inRange;
        }
    }
    times = std::min(times, std::max(inRange, kLeastCut));
    for (std::size_t m = 0; m < maps.size(); ++m) {
        Parameter& parameter = maps[m].parameter;
        for (std::size_t i = t * parameter.channels; i < (t + 1) * parameter.channels; ++i) {
            const float value = parameter.values[i];
            parameter.values[i] = std::clamp(value + times * wanted(m, i), maps[m].lowest(), std::min(parameter.highest(), kLargestValue));
            maps[m].moments.first[i] = parameter.values[i] - value;
        }
    }
}

} // namespace

std::uint64_t updateCoupled(std::span<CoupledMap> maps, const CrossCurvature& cross, double residual, double viewShare, std::size_t coarser) {
    constexpr int kRounds = 2; // the second holds what the first would take out of its range
    const bool first = maps[0].moments.steps == 0;
    std::size_t grids = 0, entries = 0;
    for (CoupledMap& map : maps) {
        const std::size_t own = coarser > 1 ? countOfGrids(map.known.coarser(CoarseTexture(map.known.grid(), coarser))) : countOfGrids(map.known);
        grids = &map == &maps[0] ? own : std::min(grids, own);
        entries += map.parameter.entries();
    }
    for (CoupledMap& map : maps) {
        map.moments.noise.resize(grids);
        ++map.moments.steps;
    }
    std::vector<std::uint8_t> held(entries);
    std::vector<float> step;
    std::uint64_t skipped = 0;
    for (int round = 0; round < kRounds; ++round) {
        MapsOnGrid finest;
        skipped = fill(maps, cross, residual, viewShare, held, finest);
        CoupledSteps steps(maps, round > 0 ? 0 : first ? 1 : kLatestWeight);
        if (coarser > 1) {
            CoarseMaps coarse(finest, coarser);
            step.assign(entries, 0.f);
            coarse.spread(finest, steps.of(coarse.maps(), 0), step);
        } else
            step = steps.of(finest, 0);
        if (!hold(maps, step, held))
            break;
    }
    const auto share = float(signalShare(maps[0].moments.noise[0]));
    const bool goesOn = viewShare >= 1 && !first; // what one view sees alone would go on in the steps of others
    const float least = goesOn ? kLeastMomentum : 0.f, along = goesOn ? kLeastMomentum + (kMostMomentum - kLeastMomentum) * share : 0.f;
    std::vector<std::size_t> begin;
    for (std::size_t m = 0, entry = 0; m < maps.size(); entry += maps[m++].parameter.entries())
        begin.push_back(entry);
    forEachEntry(std::size_t(maps[0].parameter.width) * maps[0].parameter.height, [&](std::size_t t) {
        moveTexel(maps, t, [&](std::size_t m, std::size_t i) {
            const float velocity = maps[m].moments.first[i], own = step[begin[m] + i];
            const float sum = (velocity * own < 0 ? along : least) * velocity - own;
            return sum == sum ? sum : 0.f;
        });
    });
    return skipped;
}

} // namespace cmpg

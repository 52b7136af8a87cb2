// Which method of sampling to use.
#include "guiding/policy/sampling_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cmpg {
namespace {

constexpr double kGuidedRay = 1.3;          // cost of a ray of a guided path in rays of an unguided one, on a CPU
constexpr double kRouletteRay = 1.2;        // the same of a path that is ended and split, guided or not (docs/history/guiding.md)
constexpr double kPassWeight = 0.4;         // of the latest pass in the figures
constexpr double kNewRatioWeight = 0.5;     // of the latest repetition
constexpr std::uint32_t kLearn = 3;         // passes that learn before the first guided one that counts
constexpr std::uint32_t kReconsider = 32;   // passes between two later trials
constexpr std::uint32_t kRefresh = 4;       // passes before such a trial that learn for it
constexpr double kSignificant = 2;          // standard errors by which the means of two methods must differ
constexpr double kHopeless = 4;             // a method whose score is so many times the best one's is not tried again
constexpr double kCanWin = 1.5;             // nor at all, where others let expect so many times the best one's

} // namespace

void SamplingFigures::add(double moment, double raysPerPath) {
    const double weight = passes == 0 ? 1 : kPassWeight;
    variance += weight * (moment - variance);
    rays += weight * (raysPerPath - rays);
    ++passes;
}

std::size_t SamplingChoice::indexOf(const SamplingMethod& method) const {
    return std::size_t(std::find(methods_.begin(), methods_.end(), method) - methods_.begin());
}

bool SamplingChoice::differencesTell() const {
    for (std::size_t i = 0; i < methods_.size(); ++i)
        if (!methods_[i].roulette && !differences_[i].variance())
            return false;
    return true;
}

bool SamplingChoice::ratiosTell() const {
    for (std::size_t i = 0; i < methods_.size(); ++i)
        if (state_.figures[i].passes > 0 && state_.ratios[i] == 0)
            return false;
    return true;
}

SamplingFigures SamplingChoice::figures(std::size_t method) const {
    SamplingFigures f = state_.figures[method];
    if (!methods_[method].roulette && differencesTell())
        f.variance = *differences_[method].variance() * unit_;
    else if (ratiosTell())
        f.variance *= state_.ratios[method];
    f.variance = std::max(f.variance, unseenVariance(method));
    return f;
}

double SamplingChoice::unseenVariance(std::size_t method) const {
    if (!(means_[method] > 0))
        return 0;
    double missed = 0;
    for (std::size_t i = 0; i < methods_.size(); ++i) {
        if (!(means_[i] > means_[method]))
            continue;
        const double error = std::sqrt((state_.figures[i].variance + state_.figures[method].variance) / meanSpp_);
        missed = std::max(missed, means_[i] - means_[method] - kSignificant * error);
    }
    return meanSpp_ * missed * missed;
}

double SamplingChoice::score(std::size_t method) const {
    const SamplingFigures f = figures(method);
    if (f.passes == 0)
        return std::numeric_limits<double>::infinity();
    return f.variance * f.rays * (methods_[method].kind == Sampling::Bsdf ? 1 : kGuidedRay) * (methods_[method].roulette ? kRouletteRay : 1);
}

SamplingMethod SamplingChoice::best() const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < methods_.size(); ++i)
        if (score(i) < score(best))
            best = i;
    return methods_[best];
}

Sampling SamplingChoice::bestKind() const {
    std::size_t best = 0; // the first methods have no roulette
    for (std::size_t i = 1; i < methods_.size(); ++i)
        if (!methods_[i].roulette && score(i) < score(best))
            best = i;
    return methods_[best].kind;
}

// With roulette before without: where a method pays, it mostly pays with roulette. Guided before unguided, as that is what the guide learned for,
// and the last method of those first: of the automatic choice, that by light alone, which has to learn least.
std::optional<std::size_t> SamplingChoice::untried() const {
    for (const bool roulette : {true, false})
        for (const bool guided : {true, false})
            for (std::size_t i = methods_.size(); i-- > 1;)
                if (methods_[i].roulette == roulette && (methods_[i].kind != Sampling::Bsdf) == guided && (state_.tried >> i & 1) == 0 && canWin(i))
                    return i;
    return std::nullopt;
}

// What roulette did to the unguided method is what it is expected to have done to a guided one.
bool SamplingChoice::canWin(std::size_t method) const {
    const SamplingMethod w = methods_[method];
    const std::size_t split = indexOf({w.kind, true}), plain = indexOf({Sampling::Bsdf, false}), plainSplit = indexOf({Sampling::Bsdf, true});
    if (w == SamplingMethod{Sampling::Bsdf, true})
        return !(kHopeless * score(indexOf(best())) < score(0));
    if (w.roulette || w.kind == Sampling::Bsdf || split == methods_.size() || plain == methods_.size() || plainSplit == methods_.size())
        return true;
    if (state_.figures[plainSplit].passes == 0) // it was not worth trying
        return w.kind == best().kind;
    const double expected = score(split) * score(plain) / score(plainSplit);
    return !(expected > kCanWin * score(indexOf(best())));
}

std::optional<SamplingChoice::Trial> SamplingChoice::trial() const {
    if (methods_.size() < 2)
        return std::nullopt;
    if (state_.learned == 0)
        return Trial{methods_.front(), true, true};
    const std::optional<std::size_t> method = untried();
    return method ? std::optional(Trial{methods_[*method], false, state_.learned >= kLearn}) : std::nullopt;
}

void SamplingChoice::endTrial(const SamplingMethod& method) {
    if (state_.learned < kLearn)
        ++state_.learned;
    else
        state_.tried |= 1u << indexOf(method);
}

SamplingMethod SamplingChoice::next(std::uint32_t pass) const {
    return tries(pass) ? methods_[pass / kReconsider % methods_.size()] : best();
}

bool SamplingChoice::tries(std::uint32_t pass) const {
    const std::size_t other = pass / kReconsider % methods_.size();
    return methods_.size() > 1 && pass % kReconsider == 0 && score(other) < kHopeless * score(indexOf(best()));
}

bool SamplingChoice::rests(std::uint32_t pass) const {
    const std::uint32_t sinceTrial = pass % kReconsider;
    return !trial() && best() == SamplingMethod{} && sinceTrial > 0 && sinceTrial < kReconsider - kRefresh;
}

void SamplingChoice::observe(const SamplingMethod& method, double variance, double raysPerPath, bool drifting) {
    const std::size_t i = indexOf(method);
    if (i == methods_.size())
        return;
    if ((state_.rough >> i & 1) != 0)
        state_.figures[i] = {};
    state_.rough &= ~(1u << i);
    const SamplingFigures before = state_.figures[i];
    state_.figures[i].add(variance, raysPerPath);
    if (drifting) { // passes differ by more than their noise
        differences_.assign(methods_.size(), {});
        means_.assign(methods_.size(), 0.0);
    }
    const bool inARow = std::exchange(state_.last, i) == i;
    if (!drifting || !inARow || !(before.variance > 0))
        return;
    for (std::size_t other = 0; other < state_.figures.size(); ++other)
        if (other != i)
            state_.figures[other].variance *= state_.figures[i].variance / before.variance;
}

void SamplingChoice::observeRough(const SamplingMethod& method, double variance, double raysPerPath) {
    const std::size_t i = indexOf(method);
    if (i == methods_.size())
        return;
    SamplingFigures& f = state_.figures[i];
    if (f.passes > 0 && (state_.rough >> i & 1) == 0)
        return;
    state_.rough |= 1u << i;
    ++f.passes;
    f.variance += (variance - f.variance) / f.passes;
    f.rays += (raysPerPath - f.rays) / f.passes;
}

void SamplingChoice::observeResult(const SamplingMethod& method, std::span<const double> result, double unit) {
    const std::size_t i = indexOf(method);
    if (i == methods_.size())
        return;
    differences_[i].add(result);
    unit_ = unit;
}

void SamplingChoice::observeMean(const SamplingMethod& method, double mean, std::uint32_t spp) {
    const std::size_t i = indexOf(method);
    if (i == methods_.size() || !(mean > 0) || !std::isfinite(mean))
        return;
    means_[i] += (means_[i] > 0 ? kPassWeight : 1) * (mean - means_[i]);
    meanSpp_ = spp;
}

void SamplingChoice::observeRepetition(const SamplingMethod& method, double ratio) {
    const std::size_t i = indexOf(method);
    if (i == methods_.size() || !(ratio > 0) || !std::isfinite(ratio))
        return;
    double& known = state_.ratios[i];
    known = known > 0 ? known + kNewRatioWeight * (ratio - known) : ratio;
}

void SamplingChoice::observeRoulette(Sampling kind, double varianceRatio, double raysRatio) {
    const std::size_t plain = indexOf({kind, false}), i = indexOf({kind, true});
    if (plain == methods_.size() || i == methods_.size())
        return;
    state_.ratios.assign(methods_.size(), 0.0); // of figures from moments: both methods' are to be alike
    const SamplingFigures f = figures(plain);
    state_.figures[i] = {f.variance * varianceRatio, f.rays * raysRatio, f.passes};
}

void SamplingChoice::setFigures(const SamplingMethod& method, const SamplingFigures& figures) {
    if (const std::size_t i = indexOf(method); i < methods_.size()) {
        state_.figures[i] = figures;
        state_.rough &= ~(1u << i);
    }
    state_.ratios.assign(methods_.size(), 0.0);
    differences_.assign(methods_.size(), {});
    means_.assign(methods_.size(), 0.0);
}

} // namespace cmpg

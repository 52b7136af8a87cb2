// Which method of sampling to use: variance times cost of each, measured on passes that ran anyway.
#pragma once

#include "guiding/policy/pass_differences.h"
#include "guiding/sampling.h"

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace cmpg {

// Variance and cost of one method, averaged over its passes; later ones count more, as the guide gets better.
struct SamplingFigures {
    double variance = 0;  // of the result, for one sample per pixel and an adjoint of norm 1
    double rays = 0;          // per path
    std::uint32_t passes = 0; // 0: not measured
    void add(double moment, double raysPerPath);
};

// Chooses by variance x rays; guided rays count more, for the look-ups they need, and those of split paths, for what places their copies. No
// clock takes part, so equal runs choose alike.
class SamplingChoice {
  public:
    explicit SamplingChoice(std::vector<SamplingMethod> methods) : methods_(std::move(methods)), state_{std::vector<SamplingFigures>(methods_.size()), std::vector<double>(methods_.size())}, differences_(methods_.size()), means_(methods_.size()) {}

    // Trials of an optimisation, one round: the guide learns from a pass of the first method, which is measured, and from two of the method to be
    // tried next, whose gradients are better where guides pay: an optimiser remembers noisy ones. Then every other method is tried once, those with
    // roulette first, the rest only where they can still win. What comes next; none: the round is over.
    struct Trial {
        SamplingMethod method;
        bool first = false;    // it needs kernels that the others share
        bool measured = false; // for observeRepetition(); else it only learns
    };
    std::optional<Trial> trial() const;
    void endTrial(const SamplingMethod& method);
    // After that round, the method of pass number `pass`: the best, and now and then another that is not far behind, since the guide changes.
    SamplingMethod next(std::uint32_t pass) const;
    bool tries(std::uint32_t pass) const; // whether that pass is such a trial
    // Whether nothing has to be learned in that pass: the round is over, the method found best needs no guide, and no trial is near. Trials
    // come every 32nd pass; the guide learns for them in the four before.
    bool rests(std::uint32_t pass) const;
    SamplingMethod best() const;  // of those that were measured; the first where none was
    Sampling bestKind() const; // of the methods without roulette
    // `drifting`: what is estimated changes from pass to pass, as the adjoint of an optimisation does. A change of the figures between two
    // passes in a row of one method then counts for all: otherwise methods measured long ago could never catch up.
    void observe(const SamplingMethod& method, double variance, double raysPerPath, bool drifting = false);
    // A pass whose variance a few entries share, which says little: the mean of such passes stands where no pass of the method said more. So a method whose
    // noise is always a few bright paths is known as well, and one bright path changes nothing of what is known better.
    void observeRough(const SamplingMethod& method, double variance, double raysPerPath);
    // The result of a pass that was observed too; what is estimated, and with how many samples, must be that of the earlier ones. `unit`: of
    // variance(), for a variance summed over the result's entries. Where passes of every method without roulette can be told apart by it, the
    // figures hold the variance from differences in place of the one observed.
    void observeResult(const SamplingMethod& method, std::span<const double> result, double unit);
    // What an observed pass of `spp` samples per pixel brought in all: the sum of its contributions' sizes, as observe()'s variance has the sum of their
    // squares; what is estimated must be that of the earlier passes. A method whose passes bring significantly less than another's, both being
    // unbiased, has not drawn yet what it draws rarely: its variance counts as if all it misses came with one path of a pass.
    void observeMean(const SamplingMethod& method, double mean, std::uint32_t spp);
    // The variance of a pass that ran in two halves, from how their results differ, over that which observe() was told. While it is known for
    // every method that was measured, figures count it in: only it sees what Sobol points gain, and it holds while the variance itself drifts.
    void observeRepetition(const SamplingMethod& method, double ratio);
    // The method of a kind with roulette, by ratios to the one without.
    void observeRoulette(Sampling kind, double varianceRatio, double raysRatio);

    const std::vector<SamplingMethod>& methods() const { return methods_; }
    SamplingFigures figures(std::size_t method) const;
    void setFigures(const SamplingMethod& method, const SamplingFigures& figures);
    // All that next() and observe() go by in an optimisation, beside the methods: no results are observed there.
    struct State {
        std::vector<SamplingFigures> figures;
        std::vector<double> ratios; // of observeRepetition(); 0: not known
        std::size_t last = ~std::size_t(0); // method observed last
        std::uint32_t learned = 0, tried = 0; // passes that learned for the round; a bit for every method that was tried in it
        std::uint32_t rough = 0; // a bit for every method whose figures are of observeRough()
    };
    const State& state() const { return state_; }
    void restore(State state) { // of as many methods
        state_ = std::move(state);
        differences_.assign(methods_.size(), {});
        means_.assign(methods_.size(), 0.0);
    }
    // Variance times cost; infinite where nothing was measured.
    double score(std::size_t method) const;

  private:
    std::size_t indexOf(const SamplingMethod& method) const; // methods_.size(): none
    bool differencesTell() const;                      // the variance of every method without roulette
    bool ratiosTell() const;                           // of every method that was measured
    bool canWin(std::size_t method) const;
    std::optional<std::size_t> untried() const; // to be tried next
    double unseenVariance(std::size_t method) const; // at least, by observeMean()

    std::vector<SamplingMethod> methods_;
    State state_; // variances from moments
    std::vector<PassDifferences> differences_;
    double unit_ = 1; // of their variances
    std::vector<double> means_; // of observeMean(), later ones counting more; 0: not known
    double meanSpp_ = 0;
};

} // namespace cmpg

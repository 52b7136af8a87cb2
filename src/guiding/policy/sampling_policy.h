// Which method of sampling the passes of a run use, and in which steps the guide learns.
#pragma once

#include "guiding/policy/exploration.h"
#include "guiding/policy/gradient_noise.h"
#include "guiding/policy/sampling_choice.h"

#include <cmpg/report.h>

#include <map>

namespace cmpg {

// What was chosen for derivative passes, or for images, and from what.
struct SamplingDecision {
    SamplingMethod method;
    std::map<Sampling, SamplingFigures> figures, rouletteFigures;
};

// Those without roulette first.
std::vector<MethodFigures> figuresOf(const SamplingDecision& decision);

// Sampler state carried from one step to the next, without the parameters and the guide's tree. Units of sums are no part of it: they follow
// from the tree, the parameters and the pass.
struct GuidedState {
    SamplingChoice::State images, derivatives;
    Exploration::State exploration;
    double reference = 0;
    bool trained = false;
    std::uint32_t step = 0;
};

// How a step that learns draws. It holds for all its views.
struct StepPlan {
    SamplingMethod image, derivative;
    bool record = false;      // for the guide
    bool halves = false;      // derivative passes run in two, to tell their noise
    bool trial = false, imageTrial = false;
    std::uint32_t newKinds = 0; // of passes with kernels of their own, for a trial
};

class SamplingPolicy {
  public:
    // `immediate`: try all methods from the first step, whatever the noise.
    SamplingPolicy(Sampling asked, bool roulette, bool immediate);

    SamplingChoice images, derivatives; // methods of images, and of derivative passes in either mode
    double reference = 0;               // of the roulette, for a mean |adjoint| of 1
    bool learning = false;              // steps learn

    const StepPlan& plan() const { return plan_; }
    bool recording() const { return learning && plan_.record; }
    bool tellsNoise() const { return learning && plan_.halves; }
    // Of the next image or derivative pass.
    SamplingMethod imageMethod() const;
    SamplingMethod derivativeMethod() const;
    // Of passes that nothing is learned from; without roulette.
    SamplingMethod settledMethod(const SamplingChoice& choice) const;
    // Whether some derivative pass may draw from the guide, or have roulette.
    bool mayGuide() const;
    bool mayRoulette() const;

    // What the passes of the step cost, and how their halves differed.
    void addRays(std::uint64_t rays) { rays_ += rays; }
    GradientNoise noise;

    void endStep();     // learning steps: observes what the step told
    void abandonStep(); // back to where it began
    void beginStep();   // plans anew, after figures changed
    void trust();       // a guide was given: it is tried at once
    void setTrained() { trained_ = true; } // by passes of this run

    SamplingDecision decide(const SamplingChoice& choice) const;

    // As the last step left it, also in the midst of one.
    GuidedState state() const;
    bool fits(const GuidedState& state) const; // is of these methods
    void restore(GuidedState state);

  private:
    void planTrial(const SamplingChoice::Trial& trial);

    bool immediate_;
    bool trained_ = false; // by passes of this run or of the one that saved the guide
    Exploration exploration_;
    struct Start {
        SamplingChoice images, derivatives;
        Exploration exploration;
        double reference;
    };
    Start stepStart_; // what an abandoned step returns to
    StepPlan plan_;
    std::uint64_t rays_ = 0; // of the step
    std::uint32_t step_ = 0;
};

} // namespace cmpg

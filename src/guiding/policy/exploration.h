// When an optimisation looks for better methods of sampling than the plain one, and what it may spend on that.
#pragma once

#include <cstdint>

namespace cmpg {

// Where the gradients of plain passes are precise already, no other method can gain much, and none is tried. Where their noise exceeds them in
// the first steps, all methods are tried at once. In between, and later, a share of all rays may go into trials. No clock takes part, so equal
// runs decide alike.
class Exploration {
  public:
    struct State {
        double noise = 0;          // of plain passes, see observeNoise(), later ones counting more
        std::uint32_t watched = 0; // how many of them there were
        bool urgent = false;       // methods are tried whatever that costs
        double spent = 0, trials = 0; // rays: of all passes, kernels included; of these, what plain passes would not have cost
    };

    // Whether the plain passes of that step are to tell their noise: the first ones, and now and then another.
    bool watches(std::uint32_t step) const;
    // Squared standard error over squared length of a step's gradient.
    void observeNoise(double noise);
    // The rays of a step, and what of them, or beyond them for kernels, went into trials.
    void spend(double rays, double trials);
    // Whether trials may go on that bring so many kinds of passes with kernels of their own.
    bool allows(std::uint32_t newKinds) const;
    // Trials need no reason any more.
    void hurry() { state_.urgent = true; }

    const State& state() const { return state_; }
    void restore(const State& state) { state_ = state; }

  private:
    State state_;
};

constexpr double kKernelRays = 6e6; // rays in whose time the kernels of one kind of pass are compiled, on two cores of a CPU

} // namespace cmpg

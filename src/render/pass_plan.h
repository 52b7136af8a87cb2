// What goes into a pass, and what a pass says of itself.
#pragma once

#include "guiding/sampling.h"

#include <algorithm>
#include <cstdint>

namespace cmpg {

struct Camera;

struct View {
    const Camera* camera = nullptr;
    int width = 512, height = 512;
};

// Keys of the random numbers of one pass. Different passes of one step are independent.
struct PassKey {
    std::uint64_t seed = 0;
    std::uint32_t step = 0;
    // 0 primal, 1 derivative, 2 pilot, 3 learning, 4 gate of the roulette, 5 and 6 second halves of images and derivatives, 7 pictures of a report;
    // + 8: the half for negative terms; + 16 n: of the n-th batch of a command that goes in batches.
    std::uint32_t pass = 0;
    std::uint32_t firstSample = 0; // of every pixel, in its sequence; films count for themselves
};

// How a pass draws directions, and what it leaves behind. All but the defaults and `sign` need RenderConfig::guiding.
struct PassPlan {
    SamplingMethod method = {}; // roulette only in reverse mode; it needs RenderConfig::roulette
    bool record = false;        // leave records for updateGuide(); measure too
    bool keepRecords = true;    // false: none are left. The kernels are those of `record`, which saves compiling others
    // The kernels are those of guided passes, and in reverse mode of roulette, though this pass may have neither: one set for passes by several
    // methods, with the results of their own kernels.
    bool guidedKernels = false, rouletteKernels = false;
    bool measure = false; // reverse mode: estimate PassResult::variance
    int sign = 0;         // positivization: only derivative terms of this sign
    double reference = 0; // roulette: PassResult::reference of an earlier pass with this adjoint
};

// What a pass cost and how its result scatters.
struct PassResult {
    std::uint64_t paths = 0, rays = 0;
    double variance = 0;  // of the result, summed over its entries: an estimate from the pass itself
    double reference = 0; // reverse mode: mean over the pixels of |adjoint| times the L1 norm of the first vertex's derivative
    double concentration = 0; // reverse mode, where it is measured: share of the few largest paths in the sum of all squares

    void add(const PassResult& other) {
        paths += other.paths;
        rays += other.rays;
        variance += other.variance;
        reference += other.reference;
        concentration = std::max(concentration, other.concentration);
    }
};

} // namespace cmpg

// The methods a comparison sets side by side: names for ways of sampling.
#pragma once

#include "render/guided_passes.h"

#include <string>
#include <vector>

namespace cmpg {

struct CompareMethod {
    std::string name; // as given
    GuidedOptions options;
    bool lightSampling = true;
    Sampler sampler = Sampler::Sobol;

    bool needsGuide() const { return options.sampling != Sampling::Bsdf || options.roulette; }
    std::string describe() const; // in words
};

// NAME[+PART...], comma-separated. Names:
//   plain, bsdf                                   materials and lights alone, uniform pixels, no roulette
//   primal, differential, uniform, conditional    that guide, uniform pixels, no roulette
//   ours, auto                                    the program's defaults: chosen guide, pixels by the adjoint, gated roulette
// Parts: pixels, roulette, positivize, nee, sobol, independent, and no<part> of the first four to take them away.
// `base`: what light sampling and sampler are where no part says otherwise. Error(Usage) on unknown or repeated names.
std::vector<CompareMethod> parseMethods(const std::string& list, const CompareMethod& base);

const char* samplingName(Sampling sampling);

} // namespace cmpg

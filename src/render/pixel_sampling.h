// Samples per pixel of a derivative pass, spent where the adjoint is large.
#pragma once

#include "render/renderer.h"

namespace cmpg {

struct PixelSamples {
    std::vector<std::uint32_t> counts; // samples the pixel gets in this pass
    std::vector<float> weights;        // 1/E[count]: makes the weighted sum over the samples unbiased
};

// E[n_p] = spp (0.2 + 0.8 share_p), share_p in proportion to the mean over the channels of |adjoint| and 1 on average, so that the
// pass costs what `spp` samples everywhere cost. The floor bounds the weights where the adjoint is small by chance. The rounding of
// E[n_p] to a count is random, from a counter of its own: no path shares its numbers. An adjoint of zeros gives `spp` everywhere;
// a non-finite one counts as zero.
PixelSamples sampleCounts(const Image& adjoint, std::uint32_t spp, const PassKey& key);

} // namespace cmpg

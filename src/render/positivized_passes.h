// Positivization: a derivative pass as two of half the samples, one for each sign of its terms, each guided towards its own
// (Chang et al. 2023).
#pragma once

#include "render/pass_plan.h"
#include "scene/image.h"

#include <algorithm>

namespace cmpg {

// Key and sign of one of the two passes, which go to `pass(samples, key, sign)`.
template <class Pass> void forEachSign(std::uint32_t samples, const PassKey& key, Pass&& pass) {
    constexpr std::uint32_t kNegativeHalf = 8;
    const std::uint32_t each = std::max(1u, samples / 2);
    pass(each, key, 1);
    pass(each, PassKey{key.seed, key.step, key.pass + kNegativeHalf}, -1);
}

// In forward mode: the sum of both signs' images. `pass(samples, key, sign)` returns one.
template <class Pass> Image positivizedImage(std::uint32_t samples, const PassKey& key, Pass&& pass) {
    Image sum;
    forEachSign(samples, key, [&](std::uint32_t n, const PassKey& own, int sign) {
        const Image part = pass(n, own, sign);
        if (sum.values.empty())
            sum = part;
        else
            for (std::size_t i = 0; i < sum.values.size(); ++i)
                sum.values[i] += part.values[i];
    });
    return sum;
}

// In reverse mode, where passes add to gradients by themselves. `pass(samples, key, sign)` returns its PassResult.
template <class Pass> PassResult positivizedGradient(std::uint32_t samples, const PassKey& key, Pass&& pass) {
    PassResult sum;
    forEachSign(samples, key, [&](std::uint32_t n, const PassKey& own, int sign) { sum.add(pass(n, own, sign)); });
    sum.reference /= 2; // each of the two met all derivatives
    return sum;
}

} // namespace cmpg

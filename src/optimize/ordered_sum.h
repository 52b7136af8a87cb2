// Parallel sums whose rounding does not depend on the number of threads.
#pragma once

#include "base/parallel.h"

#include <algorithm>
#include <vector>

namespace cmpg {

// `part(begin, end)` returns the sum over a range of [0, count). Ranges are fixed by `chunk` alone; their sums are added in order.
template <class Sum, class Part> Sum orderedSum(std::size_t count, std::size_t chunk, const Part& part) {
    const std::size_t chunks = (count + chunk - 1) / chunk;
    std::vector<Sum> sums(chunks);
    parallelFor(chunks, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            sums[i] = part(i * chunk, std::min(count, (i + 1) * chunk));
    });
    Sum total{};
    for (const Sum& sum : sums)
        total += sum;
    return total;
}

} // namespace cmpg

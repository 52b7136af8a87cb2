// Loops over the entries of a texture, on all threads; sums have a fixed order.
#pragma once

#include "base/parallel.h"
#include "optimize/ordered_sum.h"

#include <cstddef>

namespace cmpg {

constexpr std::size_t kEntriesAtOnce = 1 << 15;

template <class Entry> void forEachEntry(std::size_t count, const Entry& entry) {
    parallelFor(count, kEntriesAtOnce, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            entry(i);
    });
}

template <class Term> double sumOfEntries(std::size_t count, const Term& term) {
    return orderedSum<double>(count, kEntriesAtOnce, [&](std::size_t begin, std::size_t end) {
        constexpr std::size_t kSums = 4; // an addition need not wait for the one before it
        double sums[kSums] = {};
        std::size_t i = begin;
        for (; i + kSums <= end; i += kSums)
            for (std::size_t k = 0; k < kSums; ++k)
                sums[k] += term(i + k);
        for (; i < end; ++i)
            sums[0] += term(i);
        return (sums[0] + sums[1]) + (sums[2] + sums[3]);
    });
}

} // namespace cmpg

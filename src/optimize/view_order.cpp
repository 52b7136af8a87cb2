// Which views a step sees, where it does not see all.
#include "optimize/view_order.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace cmpg {
namespace {

constexpr std::uint64_t kMostViews = 16; // of a step, where their number grows: steps of more take long and tell hardly more

// SplitMix64 (Steele, Lea and Flood 2014): the same numbers on every platform, which std::shuffle does not promise.
struct SplitMix {
    std::uint64_t state;
    std::uint64_t operator()() {
        std::uint64_t z = state += 0x9e3779b97f4a7c15ull;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return z ^ (z >> 31);
    }
};

std::vector<std::size_t> randomOrder(std::uint64_t seed, std::uint64_t round, std::size_t views) {
    std::vector<std::size_t> order(views);
    std::iota(order.begin(), order.end(), std::size_t(0));
    SplitMix random{SplitMix{seed ^ 0x7669657773ull}() + round};
    for (std::size_t i = views; i > 1; --i)
        std::swap(order[i - 1], order[random() % i]); // the modulo's bias is i / 2^64
    return order;
}

} // namespace

ViewOrder::Place ViewOrder::at(std::uint32_t step) const {
    const std::uint64_t most = std::min<std::uint64_t>(views_, perStep_ > 0 ? perStep_ : kMostViews);
    std::uint64_t left = step;
    for (std::uint64_t order = 0;; ++order) {
        const std::uint64_t count = perStep_ > 0 ? most : std::min(order + 1, most), steps = (views_ + count - 1) / count;
        if (count == most) {
            order += left / steps;
            left %= steps;
        }
        if (left < steps) {
            const std::uint64_t begin = views_ * left / steps, end = views_ * (left + 1) / steps;
            return {order * views_ + begin, end - begin};
        }
        left -= steps;
    }
}

std::uint32_t ViewOrder::stepsBeforeAll() const {
    constexpr std::uint32_t kNever = ~0u;
    if (perStep_ > 0)
        return perStep_ >= views_ ? 0 : kNever;
    std::uint32_t first = 0, last = kNever; // after one that sees all, all do
    while (first < last)
        if (const std::uint32_t middle = first + (last - first) / 2; seesAll(middle))
            last = middle;
        else
            first = middle + 1;
    return first;
}

std::vector<std::size_t> ViewOrder::viewsOf(std::uint32_t step) const {
    const Place place = at(step);
    if (place.count >= views_) {
        std::vector<std::size_t> all(views_);
        std::iota(all.begin(), all.end(), std::size_t(0));
        return all;
    }
    const std::vector<std::size_t> order = randomOrder(seed_, place.seen / views_, views_);
    const auto first = order.begin() + std::ptrdiff_t(place.seen % views_);
    return {first, first + std::ptrdiff_t(place.count)};
}

std::uint32_t ViewOrder::wholeOrders(std::uint32_t start, std::uint32_t step) const {
    const std::uint64_t first = (seenBefore(start) + views_ - 1) / views_;
    return std::uint32_t(std::max(seenBefore(step) / views_, first) - first);
}

} // namespace cmpg

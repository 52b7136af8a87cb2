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
    if (perStep_ > 0) {
        const std::uint64_t count = std::min<std::uint64_t>(perStep_, views_);
        return {step * count, count};
    }
    // No step sees views of two orders: it could see one twice.
    const std::uint64_t most = std::min<std::uint64_t>(views_, kMostViews);
    std::uint64_t left = step;
    for (std::uint64_t order = 0;; ++order) {
        const std::uint64_t count = std::min(order + 1, most), steps = (views_ + count - 1) / count;
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
    std::vector<std::size_t> result;
    if (place.count >= views_) {
        result.resize(views_);
        std::iota(result.begin(), result.end(), std::size_t(0));
        return result;
    }
    std::uint64_t round = ~0ull;
    std::vector<std::size_t> order;
    for (std::uint64_t next = place.seen; result.size() < place.count; ++next) {
        if (next / views_ != round)
            order = randomOrder(seed_, round = next / views_, views_);
        result.push_back(order[next % views_]);
    }
    return result;
}

} // namespace cmpg

// Which views a step sees, where it does not see all.
#include "optimize/view_order.h"

#include <numeric>
#include <utility>

namespace cmpg {
namespace {

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

std::vector<std::size_t> viewsOfStep(std::uint64_t seed, std::uint32_t step, std::size_t views, std::uint32_t perStep) {
    std::vector<std::size_t> result;
    if (perStep == 0 || perStep >= views) {
        result.resize(views);
        std::iota(result.begin(), result.end(), std::size_t(0));
        return result;
    }
    std::uint64_t round = ~0ull;
    std::vector<std::size_t> order;
    for (std::uint64_t place = std::uint64_t(step) * perStep; result.size() < perStep; ++place) {
        if (place / views != round)
            order = randomOrder(seed, round = place / views, views);
        result.push_back(order[place % views]);
    }
    return result;
}

} // namespace cmpg

// Forward gradients against finite differences of independent renders, with what the comparison could have seen.
#pragma once

#include "scene/image.h"
#include "scene/scene.h"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

// What is checked. Repetitions are independent of each other, and forward() of render(). Equal repetitions of render() share their
// random numbers, which takes most of the noise out of a difference; the noise that is left is measured over the repetitions.
struct CheckSubject {
    const Parameter* parameter = nullptr;
    std::vector<float> values, direction; // entries() each
    std::function<Image(std::uint32_t repetition)> forward;
    std::function<Image(std::uint32_t repetition, std::span<const float> values)> render;
};

constexpr std::uint32_t kCheckRepetitions = 16;
constexpr int kCheckBlocks = 8; // per side of the image

struct Comparison {
    std::string what;               // "red mean", "block 3,5" (column, row)
    double forward = 0, finite = 0; // means over the repetitions
    double standardError = 0;       // joint
    double systematic = 0;          // bound of truncation and rounding of the finite difference
    double probability = 1;         // of so large a deviation by chance
    double z() const { return standardError > 0 ? (forward - finite) / standardError : 0; }
    double relativeError() const; // of the finite difference
    double power() const;         // smallest relative error that would stand out by 3 standard errors
    bool vanishes() const;        // both sides are zero within their errors: no relative error to speak of
};

struct CheckResult {
    double step = 0;                     // of the stencil, in units of the direction
    std::vector<Comparison> comparisons; // the mean of each channel, then the blocks
    double threshold = 0;                // a comparison with a lower probability is a disagreement
    bool agrees() const;
    const Comparison& worst(std::size_t from, std::size_t to) const; // of a range of comparisons, by probability
};

CheckResult checkGradient(const CheckSubject& subject);

// One table for people.
std::string describe(const CheckResult& result, const std::string& parameter, const std::string& direction);

} // namespace cmpg

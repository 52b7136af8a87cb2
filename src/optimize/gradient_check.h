// Forward gradients against finite differences of independent renders, with what the comparison could have seen.
#pragma once

#include "scene/image.h"
#include "scene/scene.h"

#include <cmpg/check.h>

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

CheckResult checkGradient(const CheckSubject& subject);

} // namespace cmpg

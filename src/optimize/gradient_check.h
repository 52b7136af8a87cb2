// Forward gradients against finite differences of images along paths of their own, with what the comparison could have seen.
#pragma once

#include "render/renderer.h"
#include "scene/scene.h"

#include <cmpg/check.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

// What is checked. Repetitions are independent of each other, and forward() of difference(). A difference is taken along paths that are drawn at `values`:
// paths drawn at the moved ones would now and then take another lobe, which a block of pixels may not show in all its repetitions and yet owe much of
// its derivative to. What no path met at `values` would be missing on both sides. The noise that is left is measured over the repetitions.
struct CheckSubject {
    const Parameter* parameter = nullptr;
    std::vector<float> values, direction; // entries() each
    std::function<Image(std::uint32_t repetition)> forward;
    std::function<ImageDifference(std::uint32_t repetition, std::span<const float> moved)> difference;
};

constexpr std::uint32_t kCheckRepetitions = 16;
constexpr int kCheckBlocks = 8; // per side of the image

CheckResult checkGradient(const CheckSubject& subject);

} // namespace cmpg

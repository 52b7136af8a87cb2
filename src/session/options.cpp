// What unset options stand for.
#include "session/options.h"

#include <cmpg/renderer.h>

#include <algorithm>

namespace cmpg {
namespace {

constexpr std::uint32_t kMostOfStep = 64; // samples per pixel of the gradient of a step, at most, where an error decides

std::uint32_t scaled(std::uint32_t balanced, Quality quality, std::uint32_t factor) {
    switch (quality) {
    case Quality::Preview:
        return std::max(1u, balanced / factor);
    case Quality::Accurate:
        return balanced * factor;
    case Quality::Balanced:
        break;
    }
    return balanced;
}

} // namespace

const char* commandName(Command command) {
    for (const auto& c : kCommands)
        if (c.value == command)
            return c.name;
    return "";
}

std::uint32_t Options::effectiveSpp() const {
    if (spp)
        return *spp;
    if (command == Command::Render && hasBudget())
        return kMostBudgeted;
    const bool few = command == Command::Open || command == Command::Optimize || command == Command::Compare || command == Command::Tradeoff || check;
    return scaled(few ? 16 : 64, quality, 4);
}

std::uint32_t Options::effectiveSppGradient() const {
    if (sppGradient)
        return *sppGradient;
    const bool inSteps = command == Command::Open || command == Command::Optimize || command == Command::Tradeoff ||
                       (command == Command::Compare && mode == "optimize");
    if (hasBudget() && command == Command::Gradient)
        return spp.value_or(kMostBudgeted);
    if (inSteps)
        return errorTarget ? kMostOfStep : scaled(4, quality, 4);
    return effectiveSpp();
}

std::uint32_t Options::effectiveTrain() const {
    return train.value_or(command == Command::Compare || command == Command::Tradeoff ? 8 : 0);
}

std::uint32_t Options::effectiveTrainSpp() const {
    if (trainSpp)
        return *trainSpp;
    return v1::learningSamples(command == Command::Render ? effectiveSpp() : effectiveSppGradient(), effectiveTrain(), effectiveBatches());
}

std::uint32_t Options::effectiveBatches() const {
    const bool possible = command == Command::Render || command == Command::Gradient || (command == Command::Optimize && errorTarget);
    return possible ? batches.value_or(hasBudget() ? kFewestBatches : 0) : 0;
}

std::uint32_t Options::effectiveDepth(std::uint32_t scenes) const { return maxDepth.value_or(scaled(scenes, quality, 2)); }

} // namespace cmpg

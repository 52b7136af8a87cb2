// Small random scenes: everything a scene can have, a few of each.
#pragma once

#include "scene/scene.h"

#include <cstdint>

namespace cmpg::test {

struct SceneKind {
    bool tame = false; // rough surfaces and lamps that directions find, so that estimates without light sampling have no heavy tails; no punctual lights
    bool matt = false; // surfaces that reflect diffusely alone
};

// The same scene for the same seed, on every machine. Its emitters are materials called lamp<N>.
Scene randomScene(std::uint32_t seed, SceneKind kind = {});

bool emits(const Scene& scene, std::uint32_t material);
Parameter& slotOf(Scene& scene, std::uint32_t material, SlotKind kind);
const Parameter& slotOf(const Scene& scene, std::uint32_t material, SlotKind kind);

} // namespace cmpg::test

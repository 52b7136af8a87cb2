// Slots of lobes that glTF has in extensions: the rows of shaders/shared/slots.def as the reader, its checks and the writer need them.
#pragma once

#include "scene/scene.h"

#include <vector>

namespace cmpg {

struct GltfLobeSlot {
    SlotKind kind;
    const char *extension, *factor, *texture;
    float standard; // the factor where the file gives none
    std::uint32_t channel;
    bool colour = false; // three channels, sRGB in textures
};
inline const std::vector<GltfLobeSlot> kGltfLobeSlots = {
#define LOBE_SLOT(number, Name, name, channels, highest, adam, sgd, extension, factor, standard, texture, channel) \
    {SlotKind::Name, #extension, #factor, #texture, standard, channel},
#define LOBE_COLOR_SLOT(number, Name, name, channels, highest, adam, sgd, extension, factor, standard, texture, channel) \
    {SlotKind::Name, #extension, #factor, #texture, standard, channel, true},
#include "shared/slots.def"
};

} // namespace cmpg

// Packets of the display protocol (docs/display-stream.md): bytes only, no network.
#pragma once

#include "scene/image.h"

#include <cstdint>
#include <string>
#include <vector>

namespace cmpg {

using Packet = std::vector<std::uint8_t>;

// A new image of this name and size; what had the name is gone.
Packet createPacket(const std::string& name, const Image& image);
// Values of `rows` rows from row `first` on.
Packet updatePacket(const std::string& name, const Image& image, int first, int rows);

} // namespace cmpg

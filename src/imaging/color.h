// A colour of a picture.
#pragma once

#include "scene/image.h"

#include <array>

namespace cmpg {

using Color = std::array<float, 3>; // linear RGB
constexpr Color kBlack = {0, 0, 0};

// From 8-bit sRGB.
inline Color displayColor(int red, int green, int blue) {
    return {srgbDecode(float(red) / 255), srgbDecode(float(green) / 255), srgbDecode(float(blue) / 255)};
}

} // namespace cmpg

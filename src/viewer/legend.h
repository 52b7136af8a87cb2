// Colour bars with their scale, drawn with Dear ImGui.
#pragma once

#include "viewer/picture_look.h"

namespace cmpg::viewer {

float legendHeight();
// Into a strip legendHeight() high. Nothing where the look has no scale.
void drawLegend(const PictureLook& look, const Rectangle& strip);

// Three digits.
std::string shortNumber(double value);

} // namespace cmpg::viewer

// Colours for data from nothing to a highest value: lightness grows all the way, so that they can be read without seeing hues.
#pragma once

#include "app/png_canvas.h"

namespace cmpg {

// From night blue over red to cream; `t` in [0,1], clamped.
Color heatColor(double t);

} // namespace cmpg

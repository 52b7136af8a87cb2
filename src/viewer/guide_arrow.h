// In the image, an arrow from the point that was clicked to where the guide sends rays.
#pragma once

#include "viewer/desk.h"

namespace cmpg::viewer {

// Over a picture of the image's group that stands at `place`: along the direction under the cursor in a map, else the likeliest one.
void drawGuideArrow(const Desk& desk, const Rectangle& place);

} // namespace cmpg::viewer

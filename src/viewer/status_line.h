// The line at the bottom: what is under the cursor, or what is going on.
#pragma once

#include "viewer/desk.h"

namespace cmpg::viewer {

float statusHeight();
void drawStatusLine(const Desk& desk, const Rectangle& area);
// Over the pictures, while something takes a while or has failed.
void drawNotice(const Desk& desk, const Rectangle& area);

} // namespace cmpg::viewer

// Keys and gestures: one table for what they do and for the list of them.
#pragma once

#include "viewer/desk.h"

namespace cmpg::viewer {

// Performs the shortcuts whose keys were pressed in this frame, and flies where flying keys are held. True: keys are held, and the next
// frame should follow at once.
bool handleKeys(Desk& desk);

void drawHelp(Desk& desk); // the list, while desk.help

} // namespace cmpg::viewer

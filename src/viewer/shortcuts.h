// Keys and gestures: one table for what they do and for the list of them.
#pragma once

#include "viewer/desk.h"
#include "viewer/window.h"

namespace cmpg::viewer {

// Performs the shortcuts of these keys, and flies where flying keys are held. True: keys are held, and the next frame should follow at once.
bool handleKeys(Desk& desk, std::span<const KeyPress> pressed);

void drawHelp(Desk& desk); // the list, while desk.help

} // namespace cmpg::viewer

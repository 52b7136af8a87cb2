// Devices for the tests to share.
#pragma once

#include "vk/device.h"

namespace cmpg::test {

// The device every test uses unless it needs one of its own. A portable one uses the portable kernel variants.
Device& device();
Device& portableDevice();

} // namespace cmpg::test

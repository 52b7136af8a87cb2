// Whether a device computes what it is told to. Drivers exist that do not, and say nothing: images come out black.
#pragma once

namespace cmpg {

class Device;

// Runs shaders/self_test.comp, in the variant that the device uses, and compares with known answers: Error(Device) where they differ. Once
// per process for a driver that passes. Leaves no trace in the device's accounts and times, and no submission of it is a fault's.
void selfTest(Device& device);

} // namespace cmpg

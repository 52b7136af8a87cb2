// Ctrl-C: end at once, or after the step in flight.
#pragma once

#include <atomic>

namespace cmpg {

bool stopRequested(); // after stopOnInterrupt()

// From now on the first SIGINT or SIGTERM sets the flag this returns; the second ends the program with exit code 130.
const std::atomic<bool>& stopOnInterrupt();
// SIGINT and SIGTERM end the program with exit code 130 and a message. The state at start.
void exitOnInterrupt();

} // namespace cmpg

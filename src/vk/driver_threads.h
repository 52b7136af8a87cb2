// The threads of a CPU driver on the machine's processors.
#pragma once

#include <cstdint>
#include <vector>

namespace cmpg {

// That the calling thread may use; at least one.
std::uint32_t processorsAllowed();

// lavapipe hands its workers equal parts of each dispatch and waits for the last one. Dispatches are short: Linux may wake two
// workers on one processor, and does not part them before they are done, again and again. So each worker gets a processor of its own,
// where there is one for each; with fewer threads than processors the choice stays with the system, as several processes may share the
// machine then. Results do not depend on it.
class DriverThreads {
  public:
    DriverThreads(); // before the driver starts its threads
    // After that, and before anything else starts threads. Does nothing where it cannot tell which they are.
    void spread(std::uint32_t workers) const;

  private:
    std::vector<int> before_;
};

} // namespace cmpg

// Faults that tests ask for: a device that is lost, memory that runs out, wrong results.
#pragma once

#include <cstdint>

namespace cmpg {

// From the environment variable CMPG_FAULT, a hook of tests. What is not asked for never happens, and costs a comparison per submission.
struct Fault {
    std::uint64_t submissions = ~std::uint64_t(0); // "lost:N": so many succeed, then the device is lost for good
    std::uint64_t bytes = ~std::uint64_t(0);       // "memory:N": of device memory there is no more
    std::uint64_t helpers = ~std::uint64_t(0);     // "helper:N": the same for devices that only compile
    bool wrongResults = false;                     // "wrong": the self-test of a device finds one
};
Fault faultFromEnvironment(); // Error(Usage) on another value

} // namespace cmpg

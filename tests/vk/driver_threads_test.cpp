// Each of lavapipe's workers has a processor of its own, where there is one for each.
#include "support/environment.h"
#include "support/processors.h"
#include "vk/device.h"

#include <gtest/gtest.h>

#include <sched.h>

#include <filesystem>
#include <set>
#include <string>

namespace cmpg {
namespace {

using test::processorsAllowed;

std::set<int> threads() {
    std::set<int> ids;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task"))
        ids.insert(std::stoi(entry.path().filename()));
    return ids;
}

// Processors that have one of the threads to themselves, as far as this process goes.
std::multiset<int> soleProcessors(const std::set<int>& without) {
    std::multiset<int> processors;
    for (const int thread : threads()) {
        cpu_set_t allowed;
        if (without.contains(thread) || sched_getaffinity(thread, sizeof allowed, &allowed) != 0 || CPU_COUNT(&allowed) != 1)
            continue;
        int processor = 0;
        while (!CPU_ISSET(processor, &allowed))
            ++processor;
        processors.insert(processor);
    }
    return processors;
}

TEST(DriverThreads, HaveAProcessorEach) {
    const std::set<int> before = threads();
    const Device device({});
    if (device.info().driver.find("llvmpipe") == std::string::npos || processorsAllowed() < 2 || int(device.driverThreads()) != processorsAllowed())
        GTEST_SKIP() << "needs lavapipe with as many threads as processors, two at least";
    const std::multiset<int> processors = soleProcessors(before);
    EXPECT_EQ(processors.size(), device.driverThreads());
    EXPECT_EQ(std::set<int>(processors.begin(), processors.end()).size(), device.driverThreads());
}

TEST(DriverThreads, AreLeftToTheSystemWhereTheyAreFew) {
    const test::Environment one("LP_NUM_THREADS", "1");
    const std::set<int> before = threads();
    const Device device({});
    EXPECT_TRUE(processorsAllowed() < 2 || soleProcessors(before).empty());
}

} // namespace
} // namespace cmpg

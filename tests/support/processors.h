// The processors that a thread may use.
#pragma once

#include <gtest/gtest.h>
#include <sched.h>

namespace cmpg::test {

inline cpu_set_t processors() {
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    EXPECT_EQ(sched_getaffinity(0, sizeof allowed, &allowed), 0);
    return allowed;
}

inline int processorsAllowed() {
    const cpu_set_t allowed = processors();
    return CPU_COUNT(&allowed);
}

// One processor alone of those allowed, for a scope.
class OneProcessor {
  public:
    OneProcessor() {
        cpu_set_t one = before_;
        for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&one) > 1; ++cpu)
            CPU_CLR(cpu, &one);
        EXPECT_EQ(sched_setaffinity(0, sizeof one, &one), 0);
    }
    ~OneProcessor() { EXPECT_EQ(sched_setaffinity(0, sizeof before_, &before_), 0); }
    OneProcessor(const OneProcessor&) = delete;

  private:
    const cpu_set_t before_ = processors();
};

} // namespace cmpg::test

// Wall times: since an object was made, and of a scope.
#pragma once

#include <chrono>

namespace cmpg {

class Stopwatch {
  public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// Adds its lifetime to a sum of seconds.
class ScopedTime {
  public:
    explicit ScopedTime(double& seconds) : seconds_(seconds) {}
    ~ScopedTime() { seconds_ += watch_.seconds(); }
    ScopedTime(const ScopedTime&) = delete;
    ScopedTime& operator=(const ScopedTime&) = delete;

  private:
    double& seconds_;
    Stopwatch watch_;
};

} // namespace cmpg

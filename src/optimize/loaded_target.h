// Targets of more views than memory should hold: read when a step needs them.
#pragma once

#include "optimize/target.h"

namespace cmpg {

// All but the values of what `read` gives, now and whenever it is loaded.
Target streamed(std::function<Target()> read);

// A target with its values, for as long as this lives.
class LoadedTarget {
  public:
    // Error(Input) if what is read has another size or other values than when it was first read.
    explicit LoadedTarget(const Target& target);
    LoadedTarget(const LoadedTarget&) = delete;

    const Target& operator*() const { return target_; }
    const Target* operator->() const { return &target_; }

  private:
    Target own_; // where it was read
    const Target& target_;
};

} // namespace cmpg

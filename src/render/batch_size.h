// How many paths a submission may have so that it takes about as long as asked.
#pragma once

#include <algorithm>
#include <cstdint>

namespace cmpg {

class BatchSize {
  public:
    std::uint32_t paths() const { return paths_; }

    // A submission of `paths` paths took `seconds` and should take `target`.
    void observe(std::uint32_t paths, double seconds, double target) {
        // Parts of an image differ in cost, so aim lower; and grow slowly, for what is too long is felt.
        constexpr double kAim = 0.7, kGrowth = 1.5, kShrink = 0.25;
        const double factor = std::clamp(kAim * target / std::max(seconds, 1e-6), kShrink, kGrowth);
        if (factor > 1 && paths < paths_)
            return; // the end of a pass: a small batch says little about large ones
        paths_ = std::uint32_t(std::clamp(double(paths) * factor, double(kFewest), double(kMost)));
    }

  private:
    static constexpr std::uint32_t kFewest = 256, kFirst = 2048, kMost = 1u << 30;
    std::uint32_t paths_ = kFirst;
};

} // namespace cmpg

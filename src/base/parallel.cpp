// Threads take ranges from a shared counter until none is left.
#include "base/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace cmpg {

void parallelFor(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& fn) {
    grain = std::max<std::size_t>(grain, 1);
    const std::size_t ranges = count / grain + (count % grain != 0);
    std::atomic<std::size_t> next = 0;
    std::mutex mutex;
    std::exception_ptr failure;
    std::size_t failedRange = ranges;

    // Ranges are handed out in order, so every range before a failed one has been started and reports its own failure.
    const auto work = [&] {
        for (std::size_t range; (range = next++) < ranges;) {
            try {
                const std::size_t begin = range * grain;
                fn(begin, begin + std::min(grain, count - begin));
            } catch (...) {
                const std::lock_guard lock(mutex);
                if (range < failedRange) {
                    failure = std::current_exception();
                    failedRange = range;
                }
                next = ranges;
            }
        }
    };
    {
        const std::size_t threads = std::min<std::size_t>(std::max(1u, std::thread::hardware_concurrency()), ranges);
        std::vector<std::jthread> helpers;
        for (std::size_t i = 1; i < threads; ++i)
            helpers.emplace_back(work);
        work();
    }
    if (failure)
        std::rethrow_exception(failure);
}

} // namespace cmpg

// Threads take ranges from a shared counter until none is left. They are kept for the next call: to start one takes longer than most of the work.
#include "base/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace cmpg {
namespace {

// One call of parallelFor.
class Job {
  public:
    Job(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& fn)
        : count_(count), grain_(std::max<std::size_t>(grain, 1)), ranges_(count / grain_ + (count % grain_ != 0)), failedRange_(ranges_), fn_(fn) {}

    std::size_t ranges() const { return ranges_; }

    // Ranges are handed out in order, so every range before a failed one has been started and reports its own failure.
    void work() {
        for (std::size_t range; (range = next_++) < ranges_;) {
            try {
                const std::size_t begin = range * grain_;
                fn_(begin, begin + std::min(grain_, count_ - begin));
            } catch (...) {
                const std::lock_guard lock(mutex_);
                if (range < failedRange_) {
                    failure_ = std::current_exception();
                    failedRange_ = range;
                }
                next_ = ranges_;
            }
        }
    }

    void rethrow() const {
        if (failure_)
            std::rethrow_exception(failure_);
    }

    std::size_t wanted = 0, helpers = 0; // at most, and at work; both under the lock of Helpers
    std::condition_variable left;        // the last helper did

  private:
    const std::size_t count_, grain_, ranges_;
    std::atomic<std::size_t> next_ = 0;
    std::mutex mutex_;
    std::exception_ptr failure_;
    std::size_t failedRange_;
    const std::function<void(std::size_t, std::size_t)>& fn_;
};

// Threads that wait for jobs. A caller works too and never waits for a helper that has not begun: all of them may be busy with longer jobs.
class Helpers {
  public:
    explicit Helpers(std::size_t most) : most_(most) {}

    void work(Job& job, std::size_t wanted) {
        {
            const std::lock_guard lock(mutex_);
            job.wanted = wanted;
            open_.push_back(&job);
            grow(wanted);
        }
        for (std::size_t i = 0; i < wanted; ++i)
            wake_.notify_one();
        job.work();
        std::unique_lock lock(mutex_);
        std::erase(open_, &job);
        job.left.wait(lock, [&] { return job.helpers == 0; });
    }

  private:
    void grow(std::size_t wanted) {
        try {
            for (; idle_ < wanted && threads_ < most_; ++threads_, ++idle_)
                std::thread([this] { help(); }).detach();
        } catch (const std::system_error&) { // the system has no more threads: those that are there will do
        }
    }

    void help() {
        std::unique_lock lock(mutex_);
        for (;;) { // until the process ends; counted as idle from its creation on
            wake_.wait(lock, [&] { return !open_.empty(); });
            --idle_;
            Job& job = *open_.back(); // the newest: a job may wait for one that it began
            if (++job.helpers == job.wanted)
                std::erase(open_, &job);
            lock.unlock();
            job.work();
            lock.lock();
            std::erase(open_, &job); // nothing of it is left to be begun
            ++idle_;
            if (--job.helpers == 0)
                job.left.notify_one();
        }
    }

    const std::size_t most_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::vector<Job*> open_; // those that may have ranges left
    std::size_t threads_ = 0, idle_ = 0;
};

} // namespace

void parallelFor(std::size_t count, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& fn) {
    static const std::size_t processors = std::max(1u, std::thread::hardware_concurrency());
    constexpr std::size_t kJobsAtOnce = 4; // of which each has all the helpers it can use: compilation in the background, say, beside loops
    static Helpers& helpers = *new Helpers(kJobsAtOnce * processors); // never destroyed: its threads wait until the process ends
    Job job(count, grain, fn);
    const std::size_t threads = std::min(processors, job.ranges());
    if (threads > 1)
        helpers.work(job, threads - 1);
    else
        job.work();
    job.rethrow();
}

} // namespace cmpg

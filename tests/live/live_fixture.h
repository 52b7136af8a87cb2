// A session on a bundled scene, and waiting for what it will show.
#pragma once

#include "live/live_session.h"
#include "support/temp_folder.h"

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <gtest/gtest.h>
#include <mutex>
#include <thread>

namespace cmpg::test {

inline std::string sceneFile(const std::string& name) { return std::string(CMPG_SOURCE_DIR) + "/scenes/" + name + "/scene.gltf"; }

inline Options liveOptions(const std::string& scene, std::uint32_t edge = 24) {
    Options options;
    options.input = sceneFile(scene);
    options.width = options.height = edge;
    options.maxDepth = 4;
    options.seed = 3;
    return options;
}

class Watched {
  public:
    using State = std::shared_ptr<const LiveState>;
    explicit Watched(const Options& options)
        : session_(std::make_unique<LiveSession>(options, [this] {
              const std::lock_guard lock(mutex_);
              ++news_;
              condition_.notify_all();
          })) {}

    LiveSession* operator->() { return session_.get(); }
    void close() { session_.reset(); }

    // The first state, from the present one on, that is as wanted; fails after a minute.
    template <class Wanted> State until(Wanted&& wanted, const char* what) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
        for (;;) {
            std::unique_lock lock(mutex_);
            const std::uint64_t seen = news_;
            lock.unlock();
            const State state = session_->state();
            if (wanted(*state))
                return state;
            lock.lock();
            if (!condition_.wait_until(lock, end, [&] { return news_ != seen; })) {
                ADD_FAILURE() << "never came: " << what << "; notice '" << state->notice << "', error '" << state->error.what << "', step " << state->step
                              << ", samples " << state->imageSamples << " and " << state->gradientSamples;
                return state;
            }
        }
    }
    State untilRefined() {
        return until([](const LiveState& s) { return s.scene && !s.refining && !s.busy && s.picture(LivePicture::Image); }, "the end of refinement");
    }
    State untilStep(std::uint32_t step) {
        return until([&](const LiveState& s) { return s.step >= step; }, "a step");
    }
    State untilError(std::uint32_t number = 1) {
        return until([&](const LiveState& s) { return s.error.number >= number; }, "an error");
    }

  private:
    std::mutex mutex_;
    std::condition_variable condition_;
    std::uint64_t news_ = 0;
    std::unique_ptr<LiveSession> session_; // last: its thread uses the others
};

} // namespace cmpg::test

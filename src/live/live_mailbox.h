// Between a front end and the worker of a session: wishes one way, states the other.
#pragma once

#include "live/live_session.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>

namespace cmpg {

// A file to write: what was shown when it was asked for.
struct LiveSave {
    std::filesystem::path file;
    std::function<void()> write; // throws Error
};

// What was asked for since the worker looked last.
struct LiveRequests {
    bool quit = false, reset = false;
    std::shared_ptr<const LiveState> imageAsTarget; // the state that shows the image
    std::optional<float> fill;
    std::uint32_t steps = 0, train = 0;
    std::optional<std::filesystem::path> scene;
    std::optional<std::string> target; // of `scene`, if both are there
    // Answered between two submissions, whatever the pass.
    std::optional<std::pair<int, int>> pick;
    std::vector<LiveSave> saves;
    std::optional<std::filesystem::path> sceneFolder;

    // Whether a pass under way is of no more use.
    bool restart() const { return quit || reset || imageAsTarget || fill || scene || target; }
    bool any() const { return restart() || steps > 0 || train > 0 || pick || !saves.empty() || sceneFolder; }
};

class LiveMailbox {
  public:
    explicit LiveMailbox(std::function<void()> notify) : notify_(std::move(notify)) {}

    // Front end.
    template <class Edit> void ask(Edit&& edit) {
        {
            const std::lock_guard lock(mutex_);
            edit(requests_, wished_);
            changed_ = true;
            unseen_ = true;
        }
        condition_.notify_one();
    }
    LiveSettings wished() const {
        const std::lock_guard lock(mutex_);
        return wished_;
    }
    std::shared_ptr<const LiveState> state() const {
        const std::lock_guard lock(mutex_);
        return state_;
    }

    // Worker. Whether something came since the last call: cheap, for every submission.
    bool unseen() { return unseen_.exchange(false); }
    // Calls look(requests, wished) under the lock; look may take things out.
    template <class Look> auto inspect(Look&& look) {
        const std::lock_guard lock(mutex_);
        return look(requests_, wished_);
    }
    // All requests so far and the settings wished; waits for something new first if `wait`.
    std::pair<LiveRequests, LiveSettings> take(bool wait) {
        std::unique_lock lock(mutex_);
        if (wait)
            condition_.wait(lock, [&] { return changed_; });
        changed_ = false;
        return {std::exchange(requests_, {}), wished_};
    }
    void publish(const LiveState& state) {
        auto shared = std::make_shared<const LiveState>(state);
        {
            const std::lock_guard lock(mutex_);
            state_ = std::move(shared);
        }
        if (notify_)
            notify_();
    }

  private:
    mutable std::mutex mutex_;
    std::condition_variable condition_;
    bool changed_ = false; // since take()
    std::atomic<bool> unseen_ = false;
    LiveRequests requests_;
    LiveSettings wished_;
    std::shared_ptr<const LiveState> state_ = std::make_shared<LiveState>();
    std::function<void()> notify_;
};

} // namespace cmpg

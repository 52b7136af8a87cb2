// The thread of a session: takes requests, does one piece of work, publishes, and so on.
#pragma once

#include "live/live_mailbox.h"
#include "live/live_work.h"

namespace cmpg {

class LiveWorker {
  public:
    LiveWorker(const Options& options, LiveMailbox& mailbox);
    static LiveSettings settingsAtStart(const Options& options); // before there is a scene
    void run(); // until asked to quit

  private:
    void openDevice();
    void openScene(const Options& options);
    void apply(LiveRequests& requests, const LiveSettings& wished);
    void useAsTarget(const LiveState& shown);
    void betweenSubmissions(); // of a pass: looks at what came, if anything did
    void look();               // throws LiveInterrupted where the pass under way is of no more use
    void answer(const LiveRequests& quick); // picks and files
    // Runs something that may fail; false: it did, and the state says how.
    template <class F> bool attempt(F&& f);
    void fail(const Error& error);
    void settle(); // what went wrong with the scene or the target before
    void tell(const std::string& message);
    void notice(const std::string& text, bool busy);
    void publish();

    Options options_;
    LiveMailbox& mailbox_;
    LiveState state_; // what is published next
    std::optional<v1::Device> device_;
    std::unique_ptr<LoadedScene> scene_;
    std::unique_ptr<LiveWork> work_; // of scene_
    bool stuck_ = false;             // the work failed: nothing more of it until something is asked for
};

} // namespace cmpg

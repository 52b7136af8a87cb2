// The guide of a command: learned, loaded and saved as the options say.
#pragma once

#include "render/guided_passes.h"
#include "session/session.h"

namespace cmpg {

class GuidedSession {
  public:
    // After Session::prepare(). Loads the guide that --load-guide names; Error(Input) if it is of another scene or other parameters.
    GuidedSession(const Options& options, Report& report, Session& session);
    // The same for passes that others made, as sessionOptions() says.
    GuidedSession(const Options& options, Report& report, Session& session, GuidedPasses& passes);

    GuidedPasses& passes() { return passes_; }
    // Runs the learning passes of --train, if any.
    void train(const std::function<void(std::uint32_t passes)>& run);
    // Saves the guide, and tells what was chosen.
    void finish();

  private:
    void load();

    const Options& options_;
    Report& report_;
    Session& session_;
    std::unique_ptr<GuidedPasses> own_;
    GuidedPasses& passes_;
};

// How passes are drawn, as far as options say it.
GuidedOptions guidedOptions(const Options& options);
// The same without what the command does not ask for: passes in forward mode and images have no roulette.
GuidedOptions sessionOptions(const Options& options);
// Whether the command draws from a guide or learns one.
bool usesGuide(const Options& options);

} // namespace cmpg

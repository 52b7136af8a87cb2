// The guide of an optimisation: loaded and saved as the options say.
#pragma once

#include "render/guided_passes.h"
#include "session/session.h"

#include <span>

namespace cmpg {

class GuidedSession {
  public:
    // After Session::prepare(). Loads the guide that --load-guide names; Error(Input) if it is of another scene or other parameters.
    GuidedSession(const Options& options, Report& report, Session& session, GuidedPasses& passes);

    GuidedPasses& passes() { return passes_; }
    // Saves the guide, and tells what was chosen.
    void finish();

  private:
    const Options& options_;
    Report& report_;
    Session& session_;
    GuidedPasses& passes_;
};

// Tells what passes were drawn by, in the report and to people.
void tellSampling(const Options& options, Report& report, Sampling kind, bool roulette, std::span<const MethodFigures> figures);

// How passes are drawn, as far as options say it.
GuidedOptions guidedOptions(const Options& options);
// The same without what the command does not ask for: passes in forward mode and images have no roulette.
GuidedOptions sessionOptions(const Options& options);
// Whether the command draws from a guide or learns one.
bool usesGuide(const Options& options);

} // namespace cmpg

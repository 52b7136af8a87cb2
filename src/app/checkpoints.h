// When a run keeps a checkpoint, and where it continues from one.
#pragma once

#include "app/event_log.h"
#include "base/communicator.h"
#include "base/stopwatch.h"
#include "session/library_options.h"

namespace cmpg {

class Checkpoints {
  public:
    // Of the run of these options.
    Checkpoints(const Options& options, EventLog& log);

    // Continues from the checkpoint that --resume asks for; a run without one begins at its first step, which is said. Error where
    // there is one that cannot be used, or is of another run. Without --resume, sets aside what an earlier run left in the folder, which is said.
    void resume(v1::Recovery& run);

    // Writes one if it is time. One that cannot be written is told, and no error: the run continues without.
    void afterStep(const v1::Recovery& run);
    void write(const v1::Recovery& run);

  private:
    bool on() const { return ranks().isRoot() && (interval_.steps > 0 || interval_.seconds > 0); } // all ranks have the same to keep

    std::filesystem::path folder_, resumed_;
    CheckpointInterval interval_;
    std::uint32_t steps_, stopAfter_;
    std::string config_; // of the options
    EventLog& log_;
    std::uint32_t tried_ = 0, written_ = 0; // steps of the last attempt and of the last that succeeded
    Stopwatch since_;                       // then
};

} // namespace cmpg

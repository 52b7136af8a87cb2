// When a run keeps a checkpoint, and where it goes on from one.
#pragma once

#include "base/communicator.h"
#include "base/stopwatch.h"
#include "optimize/checkpoint.h"
#include "optimize/event_log.h"
#include "session/optimize_options.h"

namespace cmpg {

class Checkpoints {
  public:
    // `madeWith`: device and driver.
    Checkpoints(const Options& options, Checkpoint::Identity identity, std::string madeWith, EventLog& log);

    // The checkpoint that --resume asks for, of this very run; none where the run begins at its first step, which is said. Error where
    // there is one that cannot be used, or is of another run.
    std::optional<Checkpoint> find() const;

    // Writes one if it is time. One that cannot be written is told, and no error: the run goes on without.
    void afterStep(const Optimization& run, const ImageModel& model);
    void write(const Optimization& run, const ImageModel& model);
    bool on() const { return ranks().isRoot() && (interval_.steps > 0 || interval_.seconds > 0); } // all ranks have the same to keep

  private:
    std::filesystem::path folder_, resumed_;
    CheckpointInterval interval_;
    std::uint32_t steps_, stopAfter_;
    Checkpoint::Identity identity_;
    std::string config_, madeWith_;
    EventLog& log_;
    std::uint32_t tried_ = 0, written_ = 0; // steps of the last attempt and of the last that succeeded
    Stopwatch since_;         // then
};

} // namespace cmpg

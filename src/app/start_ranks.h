// The ranks of a run that mpirun started.
#pragma once

#include "session/exit_status.h"
#include "session/options.h"

namespace cmpg {

// If an mpirun started this process as one of several: loads the module of its MPI, joins the others, and from then on ranks() are these. All but the
// first are silent: their output goes nowhere. Error(Device) where there is no such module.
void startRanks();
// Error(Usage) if several ranks cannot do what the options ask for.
void requireRanksFit(const Options& options);
// Of an error on this rank: the first hears of it, and ends all.
void reportRankFailure(const char* message);
// With all ranks, unless this one `failed`: then it ends the others, too.
ExitStatus endRanks(ExitStatus status, bool failed);

} // namespace cmpg

// The entry of a module that brings an MPI: what it and the program agree on.
#pragma once

#include "base/communicator.h"

namespace cmpg {

class MpiRanks : public Communicator {
  public:
    virtual void finish() = 0; // with all ranks, before the process ends
    // Has rank 0 end the run with this message, if it is not this one that does.
    virtual void reportFailure(const char* message) = 0;
    [[noreturn]] virtual void abort(int exitStatus) = 0; // of all ranks, at once
};

// Starts MPI and returns the ranks, which live until the process ends; null where MPI refuses. `stop`: whether somebody asked the run to end.
using MpiStart = MpiRanks* (*)(bool (*stop)());
constexpr const char* kMpiStart = "cmpg_mpi_start";

} // namespace cmpg

// Ranks that Python communicates for: python/cmpg/_mpi.py.
#pragma once

#include "handles.h"

#include <memory>

// `ranks`: an object of cmpg._mpi.Ranks, or None for a process alone.
std::shared_ptr<cmpg::Communicator> communicatorOf(nb::object ranks);

// The processes that share a run: its ranks.
#pragma once

#include <cmpg/communicator.h>

namespace cmpg {

// One rank, this process, that shares with nobody.
Communicator& oneRank();

// Those of this process: oneRank() until setRanks().
Communicator& ranks();
void setRanks(Communicator& communicator); // which outlives the process' work

// The sum of a long array most of whose entries may be 0 on every rank: blocks with few others are sent as pairs of index and value. Same result
// as Communicator::sum().
void sumSparse(Communicator& communicator, std::span<std::int64_t> values);

} // namespace cmpg

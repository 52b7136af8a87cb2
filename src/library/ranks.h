// Devices that ranks share: which one each takes, and what they have to agree on.
#pragma once

#include "base/error.h"

#include <cmpg/communicator.h>

#include <string>
#include <string_view>

namespace cmpg::v1 {

// A CPU driver takes all processors unless told otherwise; ranks of one machine share them. Before the driver is loaded.
void divideProcessors(const Communicator& ranks);

// For cmpg::Device::Options::select: where a machine has several graphics processors and several ranks, one after the other by local rank; else the best.
std::string deviceOfRank(const Communicator& ranks);

// The first rank whose text is not that of rank 0; 0: all have the same. All ranks learn the same.
int firstOther(Communicator& ranks, std::string_view own);

// Work that all ranks do together. What may end it on this one alone is told to the others: not errors of arguments and results, which all have.
template <class Work> auto together(Communicator& ranks, Work&& work) {
    try {
        return work();
    } catch (const Error& error) {
        if (error.kind != ErrorKind::Usage && error.kind != ErrorKind::Numerical)
            ranks.passFailed(error.what());
        throw;
    } catch (const std::exception& error) {
        ranks.passFailed(error.what());
        throw;
    } catch (...) {
        ranks.passFailed("it was ended");
        throw;
    }
}

} // namespace cmpg::v1

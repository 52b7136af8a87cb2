// Devices that ranks share: which one each takes, and what they have to agree on.
#pragma once

#include "base/error.h"

#include <cmpg/communicator.h>

#include <string>
#include <string_view>

namespace cmpg::v1 {

// A CPU driver takes all processors that it may unless told otherwise; ranks of one machine that may use the same ones share them. All ranks together, before
// the driver is loaded.
void divideProcessors(Communicator& ranks);

// For cmpg::Device::Options::select: where a machine has several graphics processors and several ranks, one after the other by local rank; else the best.
std::string deviceOfRank(const Communicator& ranks);

// The first rank whose text is not that of rank 0; 0: all have the same. All ranks learn the same.
int firstOther(Communicator& ranks, std::string_view own);

// Work that all ranks do together. What ends it is told to the others, which may wait in it: all but errors of results, which all have.
template <class Work> auto together(Communicator& ranks, Work&& work) {
    try {
        return work();
    } catch (const Error& error) {
        if (error.kind != ErrorKind::Numerical)
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

// What ranks do together begins with an agreement, which leaves all of them fit for more. Error(Usage) on all where `own`, what this one is asked for, is not
// what the others are asked for, or one of them took refuse(). `otherwise`: what a rank does that is asked for something else, than rank 0.
void agree(Communicator& ranks, std::string_view own, const std::string& otherwise, const std::string& cause);
// In place of agree(), on a rank that was asked for what cannot be.
void refuse(Communicator& ranks, const std::string& why) noexcept;

// What comes before an agreement, and may be wrong on this rank alone: arguments, files.
template <class Check> auto checked(Communicator& ranks, Check&& check) {
    try {
        return check();
    } catch (const std::exception& error) {
        refuse(ranks, error.what());
        throw;
    } catch (...) {
        refuse(ranks, "it was ended");
        throw;
    }
}

} // namespace cmpg::v1

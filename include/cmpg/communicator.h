// The processes that share passes: their ranks. Every rank makes the same passes in the same order, and all get the same results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

// What this rank has handed to the others so far.
struct Traffic {
    std::uint64_t calls = 0, bytes = 0; // of its own data, each counted once whatever the algorithm sends
    double seconds = 0;                 // spent in the calls, waiting for slower ranks included
};

// A program derives from it to share passes by whatever it communicates with (Device). Sums are of integers alone, and what is gathered comes in the
// order of the ranks: results are the same bits for any number of them. All functions throw where another rank has ended; a device whose communicator
// has thrown is of no more use. They are called by the thread that asked for the pass.
class Communicator {
  public:
    virtual ~Communicator() = default;

    virtual int rank() const = 0; // from 0
    virtual int size() const = 0;
    virtual int localRank() const = 0; // among those of this machine
    virtual int localSize() const = 0;
    bool isRoot() const { return rank() == 0; }

    // Over all ranks, entry by entry, modulo 2^64; all get the result.
    virtual void sum(std::span<std::int64_t> values) = 0;
    // From `root` to all.
    virtual void broadcast(std::span<std::byte> bytes, int root) = 0;
    // sizes[r] bytes of each rank r, one after the other; all get them.
    std::vector<std::byte> gather(std::span<const std::byte> own, std::span<const std::size_t> sizes) {
        std::vector<std::byte> all(std::accumulate(sizes.begin(), sizes.end(), std::size_t(0)));
        gatherInto(own, sizes, all);
        return all;
    }
    virtual void gatherInto(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) = 0;

    // This rank has left a pass that others may be waiting in: where they can hear of it, they are told why.
    virtual void passFailed(const std::string& why) noexcept { static_cast<void>(why); }

    virtual Traffic traffic() const { return {}; }
};

} // namespace cmpg

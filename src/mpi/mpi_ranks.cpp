// Ranks by MPI. Compiled once for each MPI there is, into a module of its own.
#include "base/stopwatch.h"
#include "mpi/mpi_entry.h"

#include <cmpg/error.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <cstdlib>
#include <mpi.h>
#include <sched.h>
#include <string>
#include <thread>

namespace cmpg {
namespace {

constexpr int kFailureTag = 1;
constexpr std::size_t kMostCount = std::size_t(1) << 27; // entries of one call: MPI counts in int
// A rank that dies has the launcher tell all others to end, and kill them a second later. A run that is to end waits no longer for others than this.
constexpr double kPatience = 0.4; // seconds

class Ranks final : public MpiRanks {
  public:
    explicit Ranks(bool (*stop)()) : stop_(stop) {
        MPI_Comm_dup(MPI_COMM_WORLD, &all_);
        MPI_Comm_dup(MPI_COMM_WORLD, &failures_);
        MPI_Comm_rank(all_, &rank_);
        MPI_Comm_size(all_, &size_);
        MPI_Comm machine;
        MPI_Comm_split_type(all_, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &machine);
        MPI_Comm_rank(machine, &localRank_);
        MPI_Comm_size(machine, &localSize_);
        MPI_Comm_free(&machine);
    }

    int rank() const override { return rank_; }
    int size() const override { return size_; }
    int localRank() const override { return localRank_; }
    int localSize() const override { return localSize_; }
    Traffic traffic() const override { return traffic_; }

    void sum(std::span<std::int64_t> values) override {
        const Call call(*this, values.size_bytes());
        for (std::size_t at = 0; at < values.size(); at += kMostCount) {
            MPI_Request request;
            // Unsigned: sums are modulo 2^64.
            MPI_Iallreduce(MPI_IN_PLACE, values.data() + at, int(std::min(kMostCount, values.size() - at)), MPI_UINT64_T, MPI_SUM, all_, &request);
            wait(request);
        }
    }

    void broadcast(std::span<std::byte> bytes, int root) override {
        const Call call(*this, rank_ == root ? bytes.size() : 0);
        for (std::size_t at = 0; at < bytes.size(); at += kMostCount) {
            MPI_Request request;
            MPI_Ibcast(bytes.data() + at, int(std::min(kMostCount, bytes.size() - at)), MPI_BYTE, root, all_, &request);
            wait(request);
        }
    }

    void gatherInto(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) override {
        const Call call(*this, own.size());
        std::vector<std::size_t> begin(sizes.size() + 1);
        for (std::size_t r = 0; r < sizes.size(); ++r)
            begin[r + 1] = begin[r] + sizes[r];
        if (begin.back() <= INT_MAX) {
            std::vector<int> counts(sizes.begin(), sizes.end()), offsets(begin.begin(), begin.end() - 1);
            MPI_Request request;
            MPI_Iallgatherv(own.data(), int(own.size()), MPI_BYTE, all.data(), counts.data(), offsets.data(), MPI_BYTE, all_, &request);
            wait(request);
            return;
        }
        std::copy(own.begin(), own.end(), all.begin() + std::ptrdiff_t(begin[std::size_t(rank_)]));
        for (int r = 0; r < size_; ++r)
            broadcast(all.subspan(begin[std::size_t(r)], sizes[std::size_t(r)]), r);
    }

    void finish() override { MPI_Finalize(); }

    void reportFailure(const char* message) override {
        if (rank_ == 0)
            return;
        const std::string text = message;
        MPI_Request request;
        MPI_Isend(text.data(), int(text.size()), MPI_CHAR, 0, kFailureTag, failures_, &request);
        // The first has a step to end and a checkpoint to write, and then ends all.
        const Stopwatch waited;
        // MPICH's abort waits for all ranks to answer calls still open: a probe goes on answering once the message is sent, a test of it would not.
        for (int sent = 0, found = 0; waited.seconds() < 60; std::this_thread::sleep_for(std::chrono::milliseconds(10))) {
            MPI_Test(&request, &sent, MPI_STATUS_IGNORE);
            MPI_Iprobe(MPI_ANY_SOURCE, kFailureTag, failures_, &found, MPI_STATUS_IGNORE);
        }
    }

    void abort(int exitStatus) override {
        MPI_Abort(all_, exitStatus);
        std::_Exit(exitStatus);
    }

  private:
    struct Call {
        Call(Ranks& ranks, std::size_t bytes) : time(ranks.traffic_.seconds) {
            ++ranks.traffic_.calls;
            ranks.traffic_.bytes += bytes;
        }
        ScopedTime time;
    };

    void wait(MPI_Request& request) {
        const Stopwatch waited;
        double asked = -1; // when somebody wanted the run to end
        for (int done = 0;;) {
            MPI_Test(&request, &done, MPI_STATUS_IGNORE);
            if (done)
                return;
            const double now = waited.seconds();
            if (now < 0.002) {
                sched_yield(); // ranks that share a processor
                continue;
            }
            std::this_thread::sleep_for(std::chrono::microseconds(50));
            if (rank_ == 0)
                lookForFailures();
            if (asked < 0 && stop_())
                asked = now;
            if (asked >= 0 && now - asked > kPatience)
                throw Error(ErrorKind::Device, "another rank ended, or all were told to", "a process was killed or its machine lost");
        }
    }

    void lookForFailures() {
        int found = 0;
        MPI_Status status;
        MPI_Iprobe(MPI_ANY_SOURCE, kFailureTag, failures_, &found, &status);
        if (!found)
            return;
        int length = 0;
        MPI_Get_count(&status, MPI_CHAR, &length);
        std::string text(std::size_t(length), ' ');
        MPI_Recv(text.data(), length, MPI_CHAR, status.MPI_SOURCE, kFailureTag, failures_, MPI_STATUS_IGNORE);
        throw Error(ErrorKind::Device, "rank " + std::to_string(status.MPI_SOURCE) + " of " + std::to_string(size_) + " failed: " + text);
    }

    bool (*stop_)();
    MPI_Comm all_ = MPI_COMM_NULL, failures_ = MPI_COMM_NULL;
    int rank_ = 0, size_ = 1, localRank_ = 0, localSize_ = 1;
    Traffic traffic_;
};

} // namespace
} // namespace cmpg

extern "C" __attribute__((visibility("default"))) cmpg::MpiRanks* cmpg_mpi_start(bool (*stop)()) {
    // Kernels are compiled on threads that do not call MPI.
    int provided = 0;
    if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS)
        return nullptr;
    return new cmpg::Ranks(stop);
}

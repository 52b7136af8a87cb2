// One rank, and sums of arrays that are mostly zeros.
#include "base/communicator.h"

#include <algorithm>
#include <cstring>

namespace cmpg {
namespace {

class OneRank final : public Communicator {
  public:
    int rank() const override { return 0; }
    int size() const override { return 1; }
    int localRank() const override { return 0; }
    int localSize() const override { return 1; }
    void sum(std::span<std::int64_t>) override {}
    void broadcast(std::span<std::byte>, int) override {}
    void gatherInto(std::span<const std::byte> own, std::span<const std::size_t>, std::span<std::byte> all) override { std::copy(own.begin(), own.end(), all.begin()); }
    Traffic traffic() const override { return {}; }
};

Communicator* current = nullptr;

constexpr std::size_t kBlock = std::size_t(1) << 16; // entries

// Of a block: an entry that is not 0.
struct Entry {
    std::uint64_t index;
    std::int64_t value;
};

} // namespace

Communicator& oneRank() {
    static OneRank one;
    return one;
}

Communicator& ranks() { return current ? *current : oneRank(); }

void setRanks(Communicator& communicator) { current = &communicator; }

void sumSparse(Communicator& communicator, std::span<std::int64_t> values) {
    const auto size = std::size_t(communicator.size()), rank = std::size_t(communicator.rank());
    if (size == 1)
        return;
    const std::size_t blocks = (values.size() + kBlock - 1) / kBlock;
    const auto block = [&](std::size_t b) { return values.subspan(b * kBlock, std::min(kBlock, values.size() - b * kBlock)); };
    std::vector<std::int64_t> counts(blocks * size); // of entries that are not 0, by block and rank
    for (std::size_t b = 0; b < blocks; ++b) {
        const auto entries = block(b);
        counts[b * size + rank] = std::int64_t(entries.size()) - std::count(entries.begin(), entries.end(), 0);
    }
    communicator.sum(counts);
    std::vector<std::size_t> sparse, bytes(size);
    for (std::size_t b = 0; b < blocks; ++b) {
        std::int64_t all = 0;
        for (std::size_t r = 0; r < size; ++r)
            all += counts[b * size + r];
        // Every rank gets the entries of all; a dense sum passes each rank twice.
        if (std::size_t(all) * sizeof(Entry) >= 2 * block(b).size_bytes()) {
            communicator.sum(block(b));
            continue;
        }
        if (all == 0)
            continue;
        sparse.push_back(b);
        for (std::size_t r = 0; r < size; ++r)
            bytes[r] += std::size_t(counts[b * size + r]) * sizeof(Entry);
    }
    if (sparse.empty())
        return;
    std::vector<Entry> own;
    for (const std::size_t b : sparse)
        for (std::size_t i = b * kBlock, end = i + block(b).size(); i < end; ++i)
            if (values[i] != 0) {
                own.push_back({i, values[i]});
                values[i] = 0;
            }
    const std::vector<std::byte> all = communicator.gather(std::as_bytes(std::span(own)), bytes);
    for (std::size_t at = 0; at < all.size(); at += sizeof(Entry)) {
        Entry entry;
        std::memcpy(&entry, all.data() + at, sizeof entry);
        values[entry.index] = std::int64_t(std::uint64_t(values[entry.index]) + std::uint64_t(entry.value));
    }
}

} // namespace cmpg

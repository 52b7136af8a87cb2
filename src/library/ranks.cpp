// What ranks that share a device have to agree on.
#include "library/ranks.h"

#include "base/hash.h"
#include "base/utf8.h"
#include "vk/device.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <sched.h>
#include <unistd.h>

namespace cmpg::v1 {
namespace {

// What a rank says in an agreement.
struct Word {
    std::uint64_t hash = 0; // of what it is asked for
    char refused = 0;
    char why[247] = {};
};

std::vector<Word> exchange(Communicator& ranks, const Word& own) {
    const std::vector<std::byte> all = together(
        ranks, [&] { return ranks.gather(std::as_bytes(std::span(&own, 1)), std::vector<std::size_t>(std::size_t(ranks.size()), sizeof own)); });
    std::vector<Word> words(std::size_t(ranks.size()));
    std::memcpy(words.data(), all.data(), all.size());
    return words;
}

} // namespace

void divideProcessors(Communicator& ranks) {
    if (ranks.size() == 1)
        return;
    struct Place {
        char machine[256] = {};
        cpu_set_t allowed;
    } own;
    gethostname(own.machine, sizeof own.machine - 1);
    CPU_ZERO(&own.allowed);
    const bool known = sched_getaffinity(0, sizeof own.allowed, &own.allowed) == 0;
    const std::vector<std::byte> all = ranks.gather(std::as_bytes(std::span(&own, 1)), std::vector<std::size_t>(std::size_t(ranks.size()), sizeof own));
    if (!known || ranks.localSize() == 1)
        return;
    int sharing = 0; // machines may have one name
    for (std::size_t at = 0; at < all.size() && sharing < ranks.localSize(); at += sizeof own)
        sharing += std::memcmp(all.data() + at, &own, sizeof own) == 0;
    setenv("LP_NUM_THREADS", std::to_string(std::max(1, CPU_COUNT(&own.allowed) / std::max(1, sharing))).c_str(), 0);
}

std::string deviceOfRank(const Communicator& ranks) {
    if (ranks.localSize() == 1)
        return {};
    std::vector<std::size_t> discrete;
    const std::vector<cmpg::DeviceInfo> all = cmpg::Device::list();
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].usable && all[i].type == "discrete")
            discrete.push_back(i);
    return discrete.size() < 2 ? std::string() : std::to_string(discrete[std::size_t(ranks.localRank()) % discrete.size()]);
}

int firstOther(Communicator& ranks, std::string_view own) {
    if (ranks.size() == 1)
        return 0;
    const std::uint64_t hash = hashOf(std::as_bytes(std::span(own)));
    const std::vector<std::byte> all =
        ranks.gather(std::as_bytes(std::span(&hash, 1)), std::vector<std::size_t>(std::size_t(ranks.size()), sizeof hash));
    for (int r = 1; r < ranks.size(); ++r)
        if (std::memcmp(all.data(), all.data() + std::size_t(r) * sizeof hash, sizeof hash) != 0)
            return r;
    return 0;
}

void agree(Communicator& ranks, std::string_view own, const std::string& otherwise, const std::string& cause) {
    if (ranks.size() == 1)
        return;
    const std::vector<Word> words = exchange(ranks, {.hash = hashOf(std::as_bytes(std::span(own)))});
    for (std::size_t r = 0; r < words.size(); ++r)
        if (words[r].refused)
            throw Error(ErrorKind::Usage, "rank " + std::to_string(r) + " of " + std::to_string(words.size()) + " was refused: " + words[r].why, {},
                        "see to its cause, and give all ranks the same");
    for (std::size_t r = 1; r < words.size(); ++r)
        if (words[r].hash != words[0].hash)
            throw Error(ErrorKind::Usage, "rank " + std::to_string(r) + " " + otherwise + " than rank 0", cause, "give all ranks the same");
}

void refuse(Communicator& ranks, const std::string& why) noexcept {
    if (ranks.size() == 1)
        return;
    Word own{.refused = 1};
    std::size_t length = std::min(why.size(), sizeof own.why - 1);
    while (length > 0 && length < why.size() && continuesCharacter(why[length]))
        --length;
    std::memcpy(own.why, why.data(), length);
    try {
        exchange(ranks, own);
    } catch (...) { // what was refused is what this rank has to say
    }
}

} // namespace cmpg::v1

// What ranks that share a device have to agree on.
#include "library/ranks.h"

#include "base/hash.h"
#include "vk/device.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <sched.h>
#include <unistd.h>

namespace cmpg::v1 {

void divideProcessors(const Communicator& ranks) {
    cpu_set_t allowed;
    if (ranks.localSize() == 1 || sched_getaffinity(0, sizeof allowed, &allowed) != 0)
        return;
    const int own = CPU_COUNT(&allowed), all = int(sysconf(_SC_NPROCESSORS_ONLN));
    const int threads = own < all ? own : std::max(1, all / ranks.localSize());
    setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), 0);
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

} // namespace cmpg::v1

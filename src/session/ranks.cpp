// What ranks that share a run have to agree on.
#include "session/ranks.h"

#include "base/communicator.h"
#include "base/error.h"

#include <cstring>
#include <nlohmann/json.hpp>

namespace cmpg {
namespace {

std::uint64_t hashOf(const std::string& text) { // FNV-1a
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const char c : text)
        hash = (hash ^ std::uint8_t(c)) * 0x100000001b3u;
    return hash;
}

} // namespace

std::string deviceOfRank() {
    if (ranks().localSize() == 1)
        return {};
    std::vector<std::size_t> discrete;
    const std::vector<DeviceInfo> all = Device::list();
    for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].usable && all[i].type == "discrete")
            discrete.push_back(i);
    return discrete.size() < 2 ? std::string() : std::to_string(discrete[std::size_t(ranks().localRank()) % discrete.size()]);
}

void requireSameRanks(const Device& device, const Options& options) {
    Communicator& all = ranks();
    const std::uint64_t own = hashOf(device.info().name + '\n' + device.info().driver + '\n' +
                                     toConfig(options).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    const std::vector<std::byte> found = all.gather(std::as_bytes(std::span(&own, 1)), std::vector<std::size_t>(std::size_t(all.size()), sizeof own));
    for (int r = 1; r < all.size(); ++r)
        if (std::memcmp(found.data(), found.data() + std::size_t(r) * sizeof own, sizeof own) != 0)
            throw Error(ErrorKind::Device, "rank " + std::to_string(r) + " has another device, driver or other options than rank 0",
                        "machines with different drivers or graphics processors: their results differ in the last bits",
                        "start the ranks on machines of one kind, or name a device that all have", {"device"});
}

StepAgreement agreeAfterStep(double loss, bool timeUp, bool stop) {
    Communicator& all = ranks();
    struct Word {
        double loss;
        std::uint64_t timeUp, stop;
    };
    const Word own{loss, timeUp, stop};
    const std::vector<std::byte> found = all.gather(std::as_bytes(std::span(&own, 1)), std::vector<std::size_t>(std::size_t(all.size()), sizeof own));
    std::vector<Word> words(std::size_t(all.size()));
    std::memcpy(words.data(), found.data(), found.size());
    StepAgreement agreed{words[0].timeUp != 0, false};
    for (const Word& word : words) {
        agreed.stop |= word.stop != 0;
        if (std::memcmp(&word.loss, &words[0].loss, sizeof loss) != 0)
            throw Error(ErrorKind::Numerical, "ranks have computed different losses", "a processor or a driver computes differently on one of the machines",
                        "start the ranks on machines of one kind");
    }
    return agreed;
}

nlohmann::ordered_json trafficReport() {
    const Traffic sent = ranks().traffic();
    return {{"count", ranks().size()}, {"calls", sent.calls}, {"bytes", sent.bytes}, {"seconds", sent.seconds}};
}

} // namespace cmpg

// What ranks that share a run have to agree on.
#include "session/ranks.h"

#include "base/communicator.h"
#include "base/error.h"
#include "library/ranks.h"

#include <nlohmann/json.hpp>

namespace cmpg {

void requireSameOptions(const Options& options) {
    if (const int other = v1::firstOther(ranks(), toConfig(options).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace)))
        throw Error(ErrorKind::Usage, "rank " + std::to_string(other) + " has other options than rank 0", {}, "start all ranks with the same");
}

StepAgreement agreeAfterStep(bool timeUp, bool stop) {
    Communicator& all = ranks();
    const std::byte own{std::uint8_t((timeUp ? 1 : 0) | (stop ? 2 : 0))};
    const std::vector<std::byte> found = all.gather(std::span(&own, 1), std::vector<std::size_t>(std::size_t(all.size()), 1));
    StepAgreement agreed{(found[0] & std::byte{1}) != std::byte{0}, false};
    for (const std::byte word : found)
        agreed.stop |= (word & std::byte{2}) != std::byte{0};
    return agreed;
}

std::uint32_t ofFirstRank(std::uint32_t value) {
    ranks().broadcast(std::as_writable_bytes(std::span(&value, 1)), 0);
    return value;
}

nlohmann::ordered_json trafficReport() {
    const Traffic sent = ranks().traffic();
    return {{"count", ranks().size()}, {"calls", sent.calls}, {"bytes", sent.bytes}, {"seconds", sent.seconds}};
}

} // namespace cmpg

// Faults that tests ask for.
#include "vk/fault.h"

#include "base/error.h"

#include <charconv>
#include <cstdlib>
#include <string>

namespace cmpg {

Fault faultFromEnvironment() {
    Fault fault;
    const char* value = std::getenv("CMPG_FAULT");
    if (!value || !*value)
        return fault;
    const std::string text = value;
    if (text == "wrong") {
        fault.wrongResults = true;
        return fault;
    }
    const std::size_t colon = text.find(':');
    std::uint64_t number = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(colon == std::string::npos ? end : text.data() + colon + 1, end, number);
    const std::string kind = text.substr(0, colon);
    if (error != std::errc() || rest != end || (kind != "lost" && kind != "helper" && kind != "memory"))
        throw Error(ErrorKind::Usage, "CMPG_FAULT is lost:N, helper:N, memory:N or wrong, not '" + text + "'");
    (kind == "lost" ? fault.submissions : kind == "helper" ? fault.helpers : fault.bytes) = number;
    return fault;
}

} // namespace cmpg

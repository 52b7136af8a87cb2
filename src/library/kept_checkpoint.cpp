// The checkpoint that a recovery continues from, and its note: what needs no device.
#include "library/kept_checkpoint.h"

#include "base/error.h"

#include <cmpg/recovery.h>

#include <utility>

namespace cmpg::v1 {

std::optional<Checkpoint> checkpointIn(const std::filesystem::path& folder, std::vector<std::string>& refused) {
    std::optional<Checkpoint> found = findCheckpoint(folder, refused);
    if (!found && !refused.empty())
        throw Error(ErrorKind::Input, "no checkpoint in '" + folder.string() + "' can be used: " + refused.front(), {}, "begin anew", {"resume"});
    return found;
}

std::optional<std::string> Recovery::note(const std::filesystem::path& folder) {
    std::vector<std::string> refused;
    std::optional<Checkpoint> found = checkpointIn(folder, refused);
    return found ? std::optional(std::move(found->config)) : std::nullopt;
}

std::filesystem::path Recovery::setAside(const std::filesystem::path& folder) { return setCheckpointsAside(folder); }

} // namespace cmpg::v1

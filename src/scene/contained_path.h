// Files that a scene names: inside its own folder or not at all.
#pragma once

#include <filesystem>
#include <string>

namespace cmpg {

struct ContainedPath {
    std::filesystem::path file; // symbolic links followed; it may not exist
    std::string refusal;        // why the name is refused, as "which leaves the scene's folder"; empty: it is not
    std::string cause, remedy;  // of a refusal
};

// What a relative path stands for beside a scene in `folder`, which is canonical.
ContainedPath containedPath(const std::filesystem::path& folder, const std::string& relative);

} // namespace cmpg

// Files that a scene names: inside its own folder or not at all.
#include "scene/contained_path.h"

#include <algorithm>

namespace cmpg {
namespace fs = std::filesystem;

ContainedPath containedPath(const fs::path& folder, const std::string& relative) {
    const std::size_t colon = relative.find(':');
    const bool scheme = colon != std::string::npos && relative.find('/') > colon;
    if (scheme || relative.empty() || relative.find('\\') != std::string::npos || fs::path(relative).is_absolute())
        return {{}, "which is not a relative path"};
    std::error_code error;
    const fs::path resolved = fs::weakly_canonical(folder / relative, error);
    if (error)
        return {{}, error.message()};
    const auto [inFolder, inFile] = std::mismatch(folder.begin(), folder.end(), resolved.begin(), resolved.end());
    if (inFolder != folder.end())
        return {{}, "which leaves the scene's folder"};
    return {resolved, {}};
}

} // namespace cmpg

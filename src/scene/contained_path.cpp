// Files that a scene names: inside its own folder or not at all.
#include "scene/contained_path.h"

#include <algorithm>

namespace cmpg {
namespace fs = std::filesystem;

ContainedPath containedPath(const fs::path& folder, const std::string& relative) {
    const auto refused = [](const std::string& why) {
        return ContainedPath{{}, why, "scenes may only name files inside their own folder", "put the file next to the scene and name it by a relative path"};
    };
    const std::size_t colon = relative.find(':');
    const bool scheme = colon != std::string::npos && relative.find('/') > colon;
    if (scheme || relative.empty() || fs::path(relative).is_absolute())
        return refused("which is not a relative path");
    if (relative.find('\\') != std::string::npos)
        return {{}, "which has \\ between its parts", "only Windows names folders so", "use / in place of \\"};
    std::error_code error;
    const fs::path resolved = fs::weakly_canonical(folder / relative, error);
    if (error)
        return refused(error.message());
    const auto [inFolder, inFile] = std::mismatch(folder.begin(), folder.end(), resolved.begin(), resolved.end());
    if (inFolder != folder.end())
        return refused("which leaves the scene's folder");
    return {resolved, {}, {}, {}};
}

} // namespace cmpg

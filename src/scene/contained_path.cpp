// Files that a scene names: inside its own folder or not at all.
#include "scene/contained_path.h"

#include <algorithm>

namespace cmpg {
namespace fs = std::filesystem;

namespace {

// As https://, or the C:/ of Windows; any other name may have a colon.
bool beginsUrl(const std::string& name) {
    const auto isLetter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    const auto inScheme = [&](char c) { return isLetter(c) || (c >= '0' && c <= '9') || c == '+' || c == '.' || c == '-'; };
    const std::size_t colon = name.find(':');
    if (colon == std::string::npos || colon == 0 || !isLetter(name[0]) || !std::all_of(name.begin(), name.begin() + std::ptrdiff_t(colon), inScheme))
        return false;
    return name.compare(colon, 3, "://") == 0 || (colon == 1 && name.compare(colon, 2, ":/") == 0);
}

} // namespace

ContainedPath containedPath(const fs::path& folder, const std::string& relative) {
    const auto refused = [](const std::string& why) {
        return ContainedPath{{}, why, "scenes may only name files inside their own folder", "put the file next to the scene and name it by a relative path"};
    };
    if (beginsUrl(relative) || relative.empty() || fs::path(relative).is_absolute())
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

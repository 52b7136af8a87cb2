// Writes a scene back as glTF with changed parameters.
#include "base/error.h"
#include "scene/scene.h"

namespace cmpg {

void exportGltf(const Scene&, const std::vector<std::uint32_t>&, const std::filesystem::path& folder) {
    throw Error(ExitCode::Output, "cannot export to " + folder.string() + ": not written yet");
}

} // namespace cmpg

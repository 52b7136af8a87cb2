// Scenes in the XML format of Mitsuba: version 3, and the forms of versions 0.6 and 2 that are widely used.
#pragma once

#include "scene/scene_file.h"

namespace cmpg {

extern const SceneFormat kMitsuba;

// Reads what docs/mitsuba.md says. Throws Error(Input) with file and line on plugins and properties that it does not know.
Scene loadMitsuba(const std::filesystem::path& file, const LoadOptions& options);

// The source file with current values in it, for stock Mitsuba 3 to open.
void writeMitsuba(const Scene& scene, const std::vector<std::uint32_t>& changed, ExportFolder& folder);

} // namespace cmpg

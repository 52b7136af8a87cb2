// glTF 2.0 scenes: .gltf and .glb.
#pragma once

#include "scene/scene_file.h"

namespace cmpg {

extern const SceneFormat kGltf;

// Reads exactly as docs/conventions.md says. Throws Error(Input).
Scene loadGltf(const std::filesystem::path& file, const LoadOptions& options);

// The source file with current values in it, readable by any glTF viewer.
void writeGltf(const Scene& scene, const std::vector<std::uint32_t>& changed, ExportFolder& folder);

} // namespace cmpg

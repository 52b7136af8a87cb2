// The parts of writing a scene back as glTF; writeGltf() puts them together.
#pragma once

#include "scene/export_folder.h"
#include "scene/gltf/document.h"

#include <set>

namespace cmpg {

// A file of the exported folder as a URI.
std::string uriOf(const std::string& relative);

// Puts the current values of material `index` into its JSON, for the slots in `changed`; textures go to `folder`.
void exportMaterial(Json& root, const GltfDocument& source, const Scene& scene, std::uint32_t index, const std::set<SlotKind>& changed,
                    ExportFolder& folder);

} // namespace cmpg

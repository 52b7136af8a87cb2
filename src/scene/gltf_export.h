// The parts of writing a scene back as glTF; exportGltf() puts them together.
#pragma once

#include "scene/gltf_document.h"
#include "scene/scene.h"

#include <set>

namespace cmpg {

// The files of an exported scene, by names that clash neither with each other nor with what was copied.
class ExportFolder {
  public:
    explicit ExportFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    // Writes or copies a file and returns the URI that names it.
    std::string add(const std::string& stem, const std::string& extension, std::span<const std::uint8_t> bytes);
    std::string copy(const std::filesystem::path& source, const std::filesystem::path& relative);
    const std::filesystem::path& path() const { return folder_; }

  private:
    std::filesystem::path folder_;
    std::set<std::string> taken_{"scene.gltf"};
};

// A parameter's name as a file name: everything but letters, digits, space, and .-_#() percent-encoded, so that names stay distinct.
std::string fileName(const std::string& parameterName);

// Puts the current values of material `index` into its JSON, for the slots in `changed`; textures go to `folder`.
void exportMaterial(Json& root, const GltfDocument& source, const Scene& scene, std::uint32_t index, const std::set<SlotKind>& changed,
                    ExportFolder& folder);

} // namespace cmpg

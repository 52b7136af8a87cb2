// Scenes in and out of files: the formats that are known, and what may be asked of a scene when it is read.
#pragma once

#include "scene/scene.h"

#include <map>
#include <optional>
#include <span>

namespace cmpg {

// A picture of the surroundings in place of the scene's own, or of none.
struct EnvironmentFile {
    std::filesystem::path file; // latitude-longitude; empty: the scene's own
    float rotation = 0;         // radians about +y
};

struct LoadOptions {
    // What is larger is refused, since a small file can ask for much: by instances, shared accessors, and images shared by materials.
    std::size_t maxTextureSize = kMostTexels;                // edge in texels
    std::uint64_t maxTriangles = std::uint64_t(1) << 27;     // instances included; also a third of the vertices
    std::uint64_t maxTextureBytes = std::uint64_t(16) << 30; // of all slots of all materials

    EnvironmentFile environment = {};
    // Values of the scene's own variables, by name; formats without any ignore them.
    std::map<std::string, std::string> definitions = {};
    std::optional<PixelFilter> filter = {}; // of all cameras, in place of the scene's own
};

class ExportFolder;

// A format of scene files. Each has a folder of its own beside this file.
struct SceneFormat {
    const char* name;
    std::span<const char* const> extensions; // with the dot, lower case
    // Whether a file begins like one, for files whose extension says nothing.
    bool (*begins)(std::span<const std::uint8_t> head);
    Scene (*load)(const std::filesystem::path& file, const LoadOptions& options);
    // Puts current values into a copy of the scene's file, called `exported`, a name that is reserved in `folder`.
    void (*write)(const Scene& scene, const std::vector<std::uint32_t>& changed, ExportFolder& folder);
    const char* exported; // name of the file that write() makes
};

std::span<const SceneFormat* const> sceneFormats();

// Whether the extension is one of a known format.
bool isSceneName(const std::filesystem::path& file);

// Reads a scene as docs/conventions.md says; the format follows from the extension, else from how the file begins. Throws Error(Input).
Scene loadScene(const std::filesystem::path& file, const LoadOptions& options = {});

// Writes the source scene with the given parameters' current values put back into its materials and textures (8-bit) to `folder`, as
// SceneFormat::exported; and exact values as parameters/<name>.exr beside it. No file that the scene was read from is overwritten. Throws Error(Output).
void exportScene(const Scene& scene, const std::vector<std::uint32_t>& changed, const std::filesystem::path& folder);

} // namespace cmpg

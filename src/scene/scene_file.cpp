// Which format a scene file has, and the writing that all formats share.
#include "scene/scene_file.h"

#include "base/error.h"
#include "scene/export_folder.h"
#include "scene/gltf/gltf.h"
#include "scene/image.h"
#include "scene/mitsuba/mitsuba.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>

namespace cmpg {
namespace fs = std::filesystem;
namespace {

constexpr std::array<const SceneFormat*, 2> kFormats = {&kGltf, &kMitsuba};

std::string extensionOf(const fs::path& file) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return extension;
}

const SceneFormat* byExtension(const fs::path& file) {
    const std::string extension = extensionOf(file);
    for (const SceneFormat* format : kFormats)
        for (const char* known : format->extensions)
            if (extension == known)
                return format;
    return nullptr;
}

// glTF, if nothing says otherwise: it tells what is wrong with the file.
const SceneFormat& formatOf(const fs::path& file) {
    if (const SceneFormat* known = byExtension(file))
        return *known;
    std::array<std::uint8_t, 256> head{};
    std::error_code ignored;
    std::streamsize size = 0;
    if (fs::is_regular_file(file, ignored)) {
        std::ifstream stream(file, std::ios::binary);
        stream.read(reinterpret_cast<char*>(head.data()), head.size());
        size = stream.gcount();
    }
    for (const SceneFormat* format : kFormats)
        if (format->begins(std::span(head).first(std::size_t(size))))
            return *format;
    return *kFormats.front();
}

} // namespace

std::span<const SceneFormat* const> sceneFormats() { return kFormats; }

bool isSceneName(const fs::path& file) { return byExtension(file) != nullptr; }

Scene loadScene(const fs::path& file, const LoadOptions& options) try {
    const SceneFormat& format = formatOf(file);
    Scene scene = format.load(file, options);
    scene.format = &format;
    scene.definitions = options.definitions;
    if (!options.environment.file.empty())
        scene.files.push_back(fs::weakly_canonical(options.environment.file));
    if (options.filter)
        for (Camera& camera : scene.cameras)
            camera.filter = *options.filter;
    return scene;
} catch (const std::bad_alloc&) {
    throw Error(ErrorKind::Input, file.string() + ": the scene does not fit into memory", "it is too large, or its sizes are damaged",
                "simplify it, or use a machine with more memory");
} catch (const fs::filesystem_error& e) {
    throw Error(ErrorKind::Input, file.string() + ": " + e.what(), "a file of the scene cannot be reached", "check paths and permissions");
}

void exportScene(const Scene& scene, const std::vector<std::uint32_t>& changed, const fs::path& folder) {
    if (!scene.format)
        throw Error(ErrorKind::Output, "cannot export a scene that came from no file");
    ExportFolder out(folder, scene.files);
    out.reserve(scene.format->exported);
    for (const std::uint32_t index : changed) { // first: they are what cannot be had again
        const Parameter& parameter = scene.parameters.at(index);
        const std::string name = "parameters/" + fileName(parameter.name) + ".exr";
        out.reserve(name); // copies of files that are called so go beside it
        writeExr(folder / name, imageOf(parameter));
    }
    scene.format->write(scene, changed, out);
}

} // namespace cmpg

// Writes a scene back as glTF with changed parameters, and what it refers to beside it.
#include "scene/gltf_export.h"

#include "base/error.h"
#include "scene/file_io.h"
#include "scene/image_decode.h"

#include <map>

namespace cmpg {
namespace fs = std::filesystem;
namespace {

std::string percentEncode(const std::string& text, const std::string& kept) {
    static const char* const kDigits = "0123456789ABCDEF";
    std::string out;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || kept.find(c) != std::string::npos;
        if (plain)
            out += c;
        else
            (out += '%') += {kDigits[byte >> 4], kDigits[byte & 15]};
    }
    return out;
}

std::string uriOf(const std::string& relative) { return percentEncode(relative, "-._~/"); }

// Copies the file that `holder`.uri names, if it names one, and renames the reference accordingly.
void copyReference(Json& holder, const JsonView& view, const GltfDocument& source, ExportFolder& folder) {
    const JsonView uri = view["uri"];
    if (!uri.exists() || isDataUri(uri.string())) return;
    const fs::path file = source.resolve(uri);
    if (!fileExists(file)) return; // nothing that is shown needs it, or the scene would not have loaded
    holder["uri"] = folder.copy(file, file.lexically_relative(source.folder()));
}

// Primitives without material get one that can be changed; it stands where the loader numbers it.
void addDefaultMaterial(Json& root, const std::string& name) {
    const std::size_t index = root.contains("materials") ? root["materials"].size() : 0;
    root["materials"].push_back({{"name", name}});
    for (Json& mesh : root["meshes"])
        for (Json& primitive : mesh["primitives"])
            if (!primitive.contains("material")) primitive["material"] = index;
}

void exportEnvironment(Json& root, const Scene& scene, ExportFolder& folder) {
    Parameter p = scene.parameters[scene.environment->parameter];
    p.materialise();
    Image image(int(p.width), int(p.height), 3);
    image.values = p.values;
    const std::size_t shown = root.value("scene", std::size_t(0));
    Json& json = root["scenes"][shown]["extras"]["environment"];
    json["uri"] = folder.add("environment", ".exr", encodeExr(image));
    json["intensity"] = 1;
}

void writeExactValues(const Parameter& parameter, const fs::path& folder) {
    Parameter p = parameter;
    p.materialise();
    Image image(int(p.width), int(p.height), int(p.channels));
    image.values = p.values;
    writeExr(folder / "parameters" / (fileName(p.name) + ".exr"), image);
}

} // namespace

std::string fileName(const std::string& parameterName) { return percentEncode(parameterName, " .-_#()"); }

std::string ExportFolder::add(const std::string& stem, const std::string& extension, std::span<const std::uint8_t> bytes) {
    std::string name = stem + extension;
    for (int n = 2; !taken_.insert(name).second; ++n) name = stem + "-" + std::to_string(n) + extension;
    writeFile(folder_ / name, bytes);
    return uriOf(name);
}

std::string ExportFolder::copy(const fs::path& source, const fs::path& relative) {
    taken_.insert(relative.generic_string());
    const fs::path target = folder_ / relative;
    std::error_code error;
    if (!fs::equivalent(source, target, error)) writeFile(target, readFile(source));
    return uriOf(relative.generic_string());
}

void exportGltf(const Scene& scene, const std::vector<std::uint32_t>& changed, const fs::path& folder) try {
    std::error_code error;
    if (fs::equivalent(scene.source, folder / "scene.gltf", error))
        throw Error(ErrorKind::Output, "cannot export to " + folder.string() + ": it would overwrite the scene that is being exported",
                    "the output folder is the scene's own", "choose another folder");
    for (const std::uint32_t index : changed) // first: they are what cannot be had again
        writeExactValues(scene.parameters.at(index), folder);
    const GltfDocument source(scene.source);
    Json root = source.json();
    ExportFolder out(folder);

    for (std::uint32_t i = 0; i < source.root()["buffers"].size(); ++i)
        copyReference(root["buffers"][i], source.root()["buffers"].at(i), source, out);
    for (std::uint32_t i = 0; i < source.root()["images"].size(); ++i)
        copyReference(root["images"][i], source.root()["images"].at(i), source, out);
    if (source.root()["buffers"].size() && !root["buffers"][0].contains("uri"))
        root["buffers"][0]["uri"] = out.add("scene", ".bin", source.model().buffers[0].data);

    std::map<std::uint32_t, std::set<SlotKind>> slots; // by material
    bool environmentChanged = false;
    for (const std::uint32_t index : changed) {
        const Parameter& p = scene.parameters.at(index);
        if (scene.environment && index == scene.environment->parameter)
            environmentChanged = true;
        else
            slots[index / kMaterialSlots].insert(p.kind);
    }
    if (!slots.empty() && slots.rbegin()->first == source.root()["materials"].size())
        addDefaultMaterial(root, scene.materials.back().name);
    for (const auto& [material, kinds] : slots) exportMaterial(root, source, scene, material, kinds, out);
    if (environmentChanged) {
        exportEnvironment(root, scene, out);
    } else if (scene.environment) {
        const std::size_t shown = root.value("scene", std::size_t(0));
        const JsonView view = source.root()["scenes"].at(std::uint32_t(shown))["extras"]["environment"];
        copyReference(root["scenes"][shown]["extras"]["environment"], view, source, out);
    }
    const std::string text = root.dump(1);
    writeFile(folder / "scene.gltf", std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
} catch (const Json::exception& e) {
    throw Error(ErrorKind::Output, "cannot export " + scene.source + ": " + e.what(), "the scene's file changed since it was loaded",
                "leave the scene in place during a run");
}

} // namespace cmpg

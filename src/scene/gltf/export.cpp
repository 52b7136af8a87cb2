// Writes a scene back as glTF with changed parameters, and what it refers to beside it.
#include "scene/gltf/export.h"

#include "base/error.h"
#include "scene/file_io.h"
#include "scene/gltf/gltf.h"
#include "scene/image_decode.h"

#include <map>

namespace cmpg {
namespace fs = std::filesystem;
namespace {

// Copies the file that `holder`.uri names, if it names one, and renames the reference accordingly.
void copyReference(Json& holder, const JsonView& view, const GltfDocument& source, ExportFolder& folder) {
    const JsonView uri = view["uri"];
    if (!uri.exists() || isDataUri(uri.string())) return;
    const fs::path file = source.resolve(uri);
    if (!fileExists(file)) return; // nothing that is shown needs it, or the scene would not have loaded
    holder["uri"] = uriOf(folder.copy(file, file.lexically_relative(source.folder())));
}

// Primitives without material get one that can be changed; it stands where the loader numbers it.
void addDefaultMaterial(Json& root, const std::string& name) {
    const std::size_t index = root.contains("materials") ? root["materials"].size() : 0;
    root["materials"].push_back({{"name", name}});
    for (Json& mesh : root["meshes"])
        for (Json& primitive : mesh["primitives"])
            if (!primitive.contains("material")) primitive["material"] = index;
}

// A file without scenes shows all its nodes.
void addScene(Json& root) {
    std::set<std::size_t> children;
    Json all = root.value("nodes", Json::array()), roots = Json::array();
    for (const Json& node : all)
        for (const Json& child : node.value("children", Json::array())) children.insert(child.get<std::size_t>());
    for (std::size_t i = 0; i < all.size(); ++i)
        if (!children.contains(i)) roots.push_back(i);
    root["scenes"] = Json::array({Json::object()});
    if (!roots.empty()) root["scenes"][0]["nodes"] = roots;
}

void exportEnvironment(Json& root, const Scene& scene, ExportFolder& folder) {
    if (root.value("scenes", Json::array()).empty()) addScene(root);
    const std::size_t shown = root.value("scene", std::size_t(0));
    Json& extras = root["scenes"][shown]["extras"];
    if (!extras.is_object() && !extras.is_null()) // it may be anything, and stays
        extras = Json::object({{"extras", Json(extras)}});
    Json& json = extras["environment"];
    json["uri"] = uriOf(folder.add("environment", ".exr", encodeExr(imageOf(scene.parameters[scene.environment->parameter]))));
    json["intensity"] = 1;
    if (scene.environment->replaced) json["rotation"] = scene.environment->rotation;
}

std::uint32_t materialOf(const Scene& scene, std::uint32_t parameter) {
    const auto has = [&](const Material& m) { return std::find(m.parameters.begin(), m.parameters.end(), parameter) != m.parameters.end(); };
    return std::uint32_t(std::find_if(scene.materials.begin(), scene.materials.end(), has) - scene.materials.begin());
}

} // namespace

std::string uriOf(const std::string& relative) { return percentEncode(relative, "-._~/"); }

void writeGltf(const Scene& scene, const std::vector<std::uint32_t>& changed, ExportFolder& out) try {
    const GltfDocument source(scene.source);
    Json root = source.json();

    for (std::uint32_t i = 0; i < source.root()["buffers"].size(); ++i)
        copyReference(root["buffers"][i], source.root()["buffers"].at(i), source, out);
    for (std::uint32_t i = 0; i < source.root()["images"].size(); ++i)
        copyReference(root["images"][i], source.root()["images"].at(i), source, out);
    if (source.root()["buffers"].size() && !root["buffers"][0].contains("uri"))
        root["buffers"][0]["uri"] = uriOf(out.add("scene", ".bin", source.model().buffers[0].data));

    std::map<std::uint32_t, std::set<SlotKind>> slots; // by material
    bool environmentChanged = scene.environment && scene.environment->replaced;
    for (const std::uint32_t index : changed) {
        const Parameter& p = scene.parameters.at(index);
        if (scene.environment && index == scene.environment->parameter)
            environmentChanged = true;
        else
            slots[materialOf(scene, index)].insert(p.kind);
    }
    if (!slots.empty() && slots.rbegin()->first == source.root()["materials"].size())
        addDefaultMaterial(root, scene.materials[slots.rbegin()->first].name);
    for (const auto& [material, kinds] : slots) exportMaterial(root, source, scene, material, kinds, out);
    if (environmentChanged) {
        exportEnvironment(root, scene, out);
    } else if (scene.environment) {
        const std::size_t shown = root.value("scene", std::size_t(0));
        const JsonView view = source.root()["scenes"].at(std::uint32_t(shown))["extras"]["environment"];
        copyReference(root["scenes"][shown]["extras"]["environment"], view, source, out);
    }
    const std::string text = root.dump(1);
    writeFile(out.path() / kGltf.exported, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
} catch (const Json::exception& e) {
    throw Error(ErrorKind::Output, "cannot export " + scene.source + ": " + e.what(), "the scene's file changed since it was loaded",
                "leave the scene in place during a run");
}

} // namespace cmpg

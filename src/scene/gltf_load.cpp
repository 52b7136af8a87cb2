// Reads a glTF scene: the order of the steps, the node hierarchy, and what is said about things left out.
#include "scene/gltf_load.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <new>

namespace cmpg {
namespace {

constexpr std::uint64_t kMaxDepthLimit = 4096;

glm::dmat4 localTransform(const JsonView& node) {
    const JsonView matrix = node["matrix"];
    if (matrix.exists()) {
        matrix.requireSize(16);
        glm::dmat4 m;
        for (std::uint32_t i = 0; i < 16; ++i) m[int(i / 4)][int(i % 4)] = matrix.at(i).number();
        if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) matrix.fail("is not an affine transform");
        return m;
    }
    const glm::dvec3 t = node["translation"].vec(glm::dvec3(0)), s = node["scale"].vec(glm::dvec3(1));
    const glm::dvec4 r = node["rotation"].vec(glm::dvec4(0, 0, 0, 1));
    const double length = glm::length(r);
    if (!(length > 0)) node["rotation"].fail("is not a rotation: its length is zero");
    const glm::dquat q(r.w / length, r.x / length, r.y / length, r.z / length);
    glm::dmat4 m = glm::mat4_cast(q);
    for (int i = 0; i < 3; ++i) m[i] *= s[i];
    m[3] = glm::dvec4(t, 1);
    return m;
}

JsonView shownScene(const GltfDocument& document) {
    const JsonView root = document.root(), scenes = root["scenes"];
    if (scenes.size() == 0) return JsonView(nullptr, document.name(), "scenes[0]");
    return scenes.at(root["scene"].index(scenes.size(), "scene").value_or(0));
}

// Things whose presence alone means that something is not rendered.
void noteIgnored(GltfLoad& load) {
    const auto note = [&](const std::string& extension) {
        if (!supportsExtension(extension)) load.ignored.insert(extension);
    };
    const JsonView used = load.root["extensionsUsed"];
    for (std::uint32_t i = 0; i < used.size(); ++i) note(used.at(i).string());
    for (const char* kind : {"materials", "nodes"})
        for (std::uint32_t i = 0; i < load.root[kind].size(); ++i)
            for (const std::string& extension : load.root[kind].at(i)["extensions"].keys()) note(extension);
    if (load.root["animations"].size()) load.ignored.insert("animations");
    if (load.root["scenes"].size() > 1) load.ignored.insert("scenes other than the default one");
}

bool emitsLight(const Parameter& p) {
    const auto positive = [](auto v) { return v > 0; };
    if (p.bytes.empty()) return std::any_of(p.values.begin(), p.values.end(), positive);
    return (p.scale.x > 0 || p.scale.y > 0 || p.scale.z > 0) && std::any_of(p.bytes.begin(), p.bytes.end(), positive);
}

void summarise(GltfLoad& load) {
    Scene& scene = load.scene;
    const auto join = [](const auto& parts) {
        std::string text;
        for (const std::string& part : parts) text += (text.empty() ? "" : ", ") + part;
        return text;
    };
    if (!load.ignored.empty()) load.warn("not rendered: " + join(load.ignored));
    std::vector<std::string> skipped;
    const auto count = [&](std::uint64_t number, const char* ofWhat) {
        if (number) skipped.push_back(std::to_string(number) + " " + ofWhat);
    };
    std::set<std::uint32_t> shownMeshes;
    const JsonView nodes = load.root["nodes"], meshes = load.root["meshes"];
    for (const NodeInstance& instance : load.instances)
        if (const auto mesh = nodes.at(instance.node)["mesh"].index(meshes.size(), "mesh")) shownMeshes.insert(*mesh);
    count(scene.skippedTriangles, "degenerate triangles");
    count(load.unusedVertices, "vertices no triangle uses");
    count(meshes.size() - shownMeshes.size(), "meshes no shown node uses");
    count(nodes.size() - load.instances.size(), "nodes outside the scene");
    if (!skipped.empty()) load.warn("skipped: " + join(skipped));
    if (scene.geometry.triangles.empty()) load.warn("the scene has no triangles");
    bool emits = !scene.lights.empty() || scene.environment;
    for (const Parameter& p : scene.parameters) emits |= p.kind == SlotKind::Emission && emitsLight(p);
    if (!emits) load.warn("the scene has no light at all: images will be black");
}

} // namespace

void GltfLoad::warn(const std::string& text) {
    auto& all = scene.warnings;
    if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(text);
}

std::string uniqueName(std::string name, std::set<std::string>& taken) {
    for (char& c : name)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '_'; // names are printed on terminals
    std::string unique = name;
    for (int n = 2; !taken.insert(unique).second; ++n) unique = name + "#" + std::to_string(n);
    return unique;
}

std::vector<NodeInstance> walkNodes(const GltfLoad& load) {
    const JsonView nodes = load.root["nodes"];
    const std::uint32_t count = nodes.size();
    std::vector<bool> seen(count, false);
    std::vector<NodeInstance> found, pending;
    // In file order, depth first; a stack of our own, so that a chain of a million nodes is no recursion.
    const auto push = [&](const JsonView& list, const glm::dmat4& parent) {
        for (std::uint32_t i = list.size(); i-- > 0;) pending.push_back({*list.at(i).index(count, "node"), parent});
    };
    if (load.sceneJson.exists()) {
        push(load.sceneJson["nodes"], glm::dmat4(1));
    } else { // a file without scenes shows all its nodes
        std::vector<bool> child(count, false);
        for (std::uint32_t i = 0; i < count; ++i)
            for (std::uint32_t c = 0; c < nodes.at(i)["children"].size(); ++c)
                child[*nodes.at(i)["children"].at(c).index(count, "node")] = true;
        for (std::uint32_t i = count; i-- > 0;)
            if (!child[i]) pending.push_back({i, glm::dmat4(1)});
    }
    while (!pending.empty()) {
        NodeInstance instance = pending.back();
        pending.pop_back();
        const JsonView node = nodes.at(instance.node);
        if (seen[instance.node]) node.fail("is reached twice: it has two parents or is its own ancestor");
        seen[instance.node] = true;
        instance.toWorld = instance.toWorld * localTransform(node);
        for (int i = 0; i < 16; ++i)
            if (!(std::abs(instance.toWorld[i / 4][i % 4]) < double(std::numeric_limits<float>::max())))
                node.fail("leaves the range of numbers by its transform and those above it", "a node scales too much",
                          "check the transforms of the nodes");
        push(node["children"], instance.toWorld);
        found.push_back(instance);
    }
    return found;
}

Scene loadGltf(const std::filesystem::path& file, const LoadOptions& options) try {
    GltfDocument document(file);
    GltfLoad load{document, options, {}, document.root(), shownScene(document), {}, {}};
    load.scene.source = file.string();
    load.instances = walkNodes(load);
    noteIgnored(load);
    loadMaterials(load);
    loadGeometry(load);
    loadCameras(load);
    loadLights(load);
    loadEnvironment(load);
    load.scene.maxDepth = std::uint32_t(load.sceneJson["extras"]["maxDepth"].integer(load.scene.maxDepth, kMaxDepthLimit));
    if (load.scene.maxDepth == 0) load.sceneJson["extras"]["maxDepth"].fail("is 0, but a path has at least one segment");
    summarise(load);
    return std::move(load.scene);
} catch (const std::bad_alloc&) {
    throw Error(ExitCode::Input, file.string() + ": the scene does not fit into memory", "it is too large, or its sizes are damaged",
                "simplify it, or use a machine with more memory");
} catch (const std::filesystem::filesystem_error& e) {
    throw Error(ExitCode::Input, file.string() + ": " + e.what(), "a file of the scene cannot be reached", "check paths and permissions");
}

} // namespace cmpg

// Reads a glTF scene: the order of the steps, the node hierarchy, and what is said about things left out.
#include "scene/gltf_load.h"

#include "base/error.h"
#include "scene/gltf_value.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <new>

namespace cmpg {
namespace {

glm::dmat4 localTransform(const GltfLoad& load, std::uint32_t index) {
    const tinygltf::Node& node = load.model.nodes[index];
    if (!node.matrix.empty()) {
        glm::dmat4 m = glm::make_mat4(node.matrix.data());
        constexpr double kRounding = 1e-6; // of programs that multiply and invert matrices before they write them
        const bool affine = std::abs(m[0][3]) <= kRounding && std::abs(m[1][3]) <= kRounding && std::abs(m[2][3]) <= kRounding && std::abs(m[3][3] - 1) <= kRounding;
        if (!affine)
            load.document.at(nodePlace(index) + ".matrix").fail("is not an affine transform");
        m[0][3] = m[1][3] = m[2][3] = 0;
        m[3][3] = 1;
        return m;
    }
    const glm::dvec3 t = vec(node.translation, glm::dvec3(0)), s = vec(node.scale, glm::dvec3(1));
    const glm::dvec4 r = vec(node.rotation, glm::dvec4(0, 0, 0, 1));
    const double length = glm::length(r);
    if (!(length > 0)) load.document.at(nodePlace(index) + ".rotation").fail("is not a rotation: its length is zero");
    const glm::dquat q(r.w / length, r.x / length, r.y / length, r.z / length);
    glm::dmat4 m = glm::mat4_cast(q);
    for (int i = 0; i < 3; ++i) m[i] *= s[i];
    m[3] = glm::dvec4(t, 1);
    return m;
}

const tinygltf::Scene* shownScene(const tinygltf::Model& model) {
    return model.scenes.empty() ? nullptr : &model.scenes[std::size_t(std::max(model.defaultScene, 0))];
}

// Things whose presence alone means that something is not rendered.
void noteIgnored(GltfLoad& load) {
    const auto note = [&](const std::string& extension) {
        if (!supportsExtension(extension)) load.ignored.insert(extension);
    };
    for (const std::string& extension : load.model.extensionsUsed) note(extension);
    for (const tinygltf::Material& material : load.model.materials)
        for (const auto& [extension, value] : material.extensions) note(extension);
    for (const tinygltf::Node& node : load.model.nodes)
        for (const auto& [extension, value] : node.extensions) note(extension);
    if (!load.model.animations.empty()) load.ignored.insert("animations");
    if (load.model.scenes.size() > 1) load.ignored.insert("scenes other than the default one");
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
    std::set<int> shownMeshes;
    for (const NodeInstance& instance : load.instances)
        if (const int mesh = load.model.nodes[instance.node].mesh; mesh >= 0) shownMeshes.insert(mesh);
    count(scene.skippedTriangles, "degenerate triangles");
    count(load.unusedVertices, "vertices no triangle uses");
    count(load.model.meshes.size() - shownMeshes.size(), "meshes no shown node uses");
    count(load.model.nodes.size() - load.instances.size(), "nodes outside the scene");
    if (!skipped.empty()) load.warn("skipped: " + join(skipped));
    if (scene.geometry.triangles.empty()) load.warn("the scene has no triangles");
    bool emits = !scene.lights.empty() || scene.environment;
    for (const Parameter& p : scene.parameters) emits |= p.kind == SlotKind::Emission && emitsLight(p);
    if (!emits) load.warn("the scene has no light at all: images will be black");
}

} // namespace

void GltfLoad::warn(const std::string& text) {
    if (warned.insert(text).second) scene.warnings.push_back(text);
}

void GltfLoad::addTextureBytes(std::uint64_t bytes, const std::string& parameter) {
    textureBytes += bytes;
    if (textureBytes > options.maxTextureBytes)
        throw Error(ErrorKind::Input, document.name() + ": the textures are too large: up to " + parameter + " they take " +
                                         std::to_string(textureBytes) + " bytes; at most " + std::to_string(options.maxTextureBytes) + " are read",
                    "many materials have large textures, each a copy of its own", "scale the textures down");
}

std::string uniqueName(std::string name, UniqueNames& taken) {
    for (char& c : name)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '_'; // names are printed on terminals
    const auto [like, isNew] = taken.try_emplace(name, 1);
    while (!isNew) {
        std::string numbered = name + "#" + std::to_string(++like->second);
        if (taken.try_emplace(numbered, 1).second) return numbered;
    }
    return name;
}

std::string nodePlace(std::uint32_t node) { return "nodes[" + std::to_string(node) + "]"; }

std::vector<NodeInstance> walkNodes(const GltfLoad& load) {
    const std::vector<tinygltf::Node>& nodes = load.model.nodes;
    std::vector<bool> seen(nodes.size(), false);
    std::vector<NodeInstance> found, pending;
    // In file order, depth first; a stack of our own, so that a chain of a million nodes is no recursion.
    const auto push = [&](const std::vector<int>& list, const glm::dmat4& parent) {
        for (auto node = list.rbegin(); node != list.rend(); ++node) pending.push_back({std::uint32_t(*node), parent});
    };
    if (load.shown) {
        push(load.shown->nodes, glm::dmat4(1));
    } else { // a file without scenes shows all its nodes
        std::vector<bool> child(nodes.size(), false);
        for (const tinygltf::Node& node : nodes)
            for (const int c : node.children) child[std::size_t(c)] = true;
        for (auto i = std::uint32_t(nodes.size()); i-- > 0;)
            if (!child[i]) pending.push_back({i, glm::dmat4(1)});
    }
    while (!pending.empty()) {
        NodeInstance instance = pending.back();
        pending.pop_back();
        const std::uint32_t node = instance.node;
        if (seen[node]) load.document.at(nodePlace(node)).fail("is reached twice: it has two parents or is its own ancestor");
        seen[node] = true;
        instance.toWorld = instance.toWorld * localTransform(load, node);
        for (int i = 0; i < 16; ++i)
            if (!(std::abs(instance.toWorld[i / 4][i % 4]) < double(std::numeric_limits<float>::max())))
                load.document.at(nodePlace(node)).fail("leaves the range of numbers by its transform and those above it",
                                                       "a node scales too much", "check the transforms of the nodes");
        push(nodes[node].children, instance.toWorld);
        found.push_back(instance);
    }
    return found;
}

Scene loadGltf(const std::filesystem::path& file, const LoadOptions& options) try {
    const GltfDocument document(file);
    GltfLoad load{document, document.model(), shownScene(document.model()), options, {}, {}, {}};
    load.scene.source = file.string();
    load.instances = walkNodes(load);
    noteIgnored(load);
    loadMaterials(load);
    loadGeometry(load);
    loadCameras(load);
    loadLights(load);
    loadEnvironment(load);
    if (load.shown) load.scene.maxDepth = std::uint32_t(number(member(load.shown->extras, "maxDepth"), load.scene.maxDepth));
    summarise(load);
    return std::move(load.scene);
} catch (const std::bad_alloc&) {
    throw Error(ErrorKind::Input, file.string() + ": the scene does not fit into memory", "it is too large, or its sizes are damaged",
                "simplify it, or use a machine with more memory");
} catch (const std::filesystem::filesystem_error& e) {
    throw Error(ErrorKind::Input, file.string() + ": " + e.what(), "a file of the scene cannot be reached", "check paths and permissions");
}

} // namespace cmpg

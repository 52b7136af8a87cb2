// Reads a glTF scene: the order of the steps, the node hierarchy, and what is said about things left out.
#include "scene/gltf/load.h"

#include "base/error.h"
#include "scene/gltf/gltf.h"
#include "scene/gltf/value.h"

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

void summarise(GltfLoad& load) {
    std::set<int> shownMeshes;
    for (const NodeInstance& instance : load.instances)
        if (const int mesh = load.model.nodes[instance.node].mesh; mesh >= 0) shownMeshes.insert(mesh);
    load.summarise({{load.unusedVertices, "vertices no triangle uses"},
                    {load.model.meshes.size() - shownMeshes.size(), "meshes no shown node uses"},
                    {load.model.nodes.size() - load.instances.size(), "nodes outside the scene"}});
}

bool beginsGltf(std::span<const std::uint8_t> head) {
    return head.size() >= 4 && (std::equal(head.begin(), head.begin() + 4, "glTF") || head[0] == '{');
}

constexpr const char* kExtensions[] = {".gltf", ".glb"};

} // namespace

const SceneFormat kGltf = {"glTF 2.0", kExtensions, beginsGltf, loadGltf, writeGltf, "scene.gltf"};

GltfLoad::GltfLoad(const GltfDocument& source, const LoadOptions& loadOptions)
    : SceneBuilder(source.name(), loadOptions), document(source), model(source.model()), shown(shownScene(source.model())) {}

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

Scene loadGltf(const std::filesystem::path& file, const LoadOptions& options) {
    const GltfDocument document(file);
    GltfLoad load(document, options);
    load.scene.source = file.string();
    load.scene.files = document.files();
    load.instances = walkNodes(load);
    noteIgnored(load);
    loadMaterials(load);
    loadGeometry(load);
    loadCameras(load);
    loadLights(load);
    if (options.environment.file.empty())
        loadEnvironment(load);
    else
        load.applyOptions();
    if (load.shown) load.scene.maxDepth = std::uint32_t(number(member(load.shown->extras, "maxDepth"), load.scene.maxDepth));
    summarise(load);
    return std::move(load.scene);
}

} // namespace cmpg

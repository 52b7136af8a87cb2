// The steps of reading a glTF scene; loadGltf() runs them in this order.
#pragma once

#include "scene/gltf_document.h"
#include "scene/scene.h"

#include <map>
#include <set>

namespace cmpg {

struct NodeInstance {
    std::uint32_t node;
    glm::dmat4 toWorld;
};

struct GltfLoad {
    const GltfDocument& document;
    const tinygltf::Model& model; // of the document
    const tinygltf::Scene* shown; // nullptr if the file has no scene
    LoadOptions options;
    Scene scene;
    std::vector<NodeInstance> instances;
    std::set<std::string> ignored; // what the file has and we do not render: named in one warning
    std::uint64_t unusedVertices = 0;
    std::uint64_t textureBytes = 0; // of all slots so far
    std::set<std::string> warned = {};

    void warn(const std::string& text); // once
    void addTextureBytes(std::uint64_t bytes, const std::string& parameter); // fails beyond LoadOptions::maxTextureBytes
};

// Names given so far, and the last number of their likes.
using UniqueNames = std::map<std::string, std::uint32_t>;

std::vector<NodeInstance> walkNodes(const GltfLoad& load);
void loadMaterials(GltfLoad& load);
void loadGeometry(GltfLoad& load); // sets Scene::center; what comes later subtracts it
void loadCameras(GltfLoad& load);
void loadLights(GltfLoad& load);
void loadEnvironment(GltfLoad& load);

// The index materials of primitives that name none get, and whether there is such a primitive among the instances.
std::uint32_t defaultMaterial(const GltfLoad& load);
bool usesDefaultMaterial(const GltfLoad& load);

// For messages.
std::string nodePlace(std::uint32_t node);

// `name` without control characters, made unique by #2, #3 ...
std::string uniqueName(std::string name, UniqueNames& taken);

} // namespace cmpg

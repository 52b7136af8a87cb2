// The steps of reading a glTF scene; loadGltf() runs them in this order.
#pragma once

#include "scene/gltf_document.h"
#include "scene/scene.h"

#include <set>

namespace cmpg {

struct NodeInstance {
    std::uint32_t node;
    glm::dmat4 toWorld;
};

struct GltfLoad {
    GltfDocument& document;
    LoadOptions options;
    Scene scene;
    JsonView root;
    JsonView sceneJson; // the scene of the file that is shown; absent if it has none
    std::vector<NodeInstance> instances;
    std::set<std::string> ignored; // what the file has and we do not render: named in one warning
    std::uint64_t unusedVertices = 0;

    void warn(const std::string& text);
};

std::vector<NodeInstance> walkNodes(const GltfLoad& load);
void loadMaterials(GltfLoad& load);
void loadGeometry(GltfLoad& load); // sets Scene::center; what comes later subtracts it
void loadCameras(GltfLoad& load);
void loadLights(GltfLoad& load);
void loadEnvironment(GltfLoad& load);

// The index materials of primitives that name none get, and whether there is such a primitive among the instances.
std::uint32_t defaultMaterial(const GltfLoad& load);
bool usesDefaultMaterial(const GltfLoad& load);

// `name` without control characters, made unique by #2, #3 ...
std::string uniqueName(std::string name, std::set<std::string>& taken);

} // namespace cmpg

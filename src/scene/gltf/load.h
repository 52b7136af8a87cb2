// The steps of reading a glTF scene; loadGltf() runs them in this order.
#pragma once

#include "scene/gltf/document.h"
#include "scene/scene_builder.h"

namespace cmpg {

struct NodeInstance {
    std::uint32_t node;
    glm::dmat4 toWorld;
};

struct GltfLoad : SceneBuilder {
    GltfLoad(const GltfDocument& source, const LoadOptions& loadOptions);

    const GltfDocument& document;
    const tinygltf::Model& model; // of the document
    const tinygltf::Scene* shown; // nullptr if the file has no scene
    std::vector<NodeInstance> instances;
    std::uint64_t unusedVertices = 0;
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

// For messages.
std::string nodePlace(std::uint32_t node);

} // namespace cmpg

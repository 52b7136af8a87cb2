// A scene as a glTF file, in one of several ways that mean the same.
#pragma once

#include "scene/scene.h"
#include "support/generated_geometry.h"

namespace cmpg::test {

enum class FileStyle {
    Plain,     // a mesh for each material, in world space
    Mirrored,  // every mesh inside out, in a node that mirrors it back
    Nested,    // turned and scaled in nodes below nodes, without indices, nodes in another order
    Instanced, // every triangle a node of its own, whose mesh it shares with triangles of equal attributes
};

// Whether glTF can say what the scene holds in memory: roughness and metallic share an image, alpha is that of the base colour.
bool fitsFile(const Scene& scene);

// Written and loaded again. Materials and parameters keep their order; constants may come back as textures.
Scene throughFile(const Scene& scene, FileStyle style, generated::Random& random);

} // namespace cmpg::test

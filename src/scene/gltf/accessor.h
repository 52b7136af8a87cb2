// Numbers out of glTF accessors: any component type, normalised, strided, sparse; every bound checked.
#pragma once

#include "scene/gltf/document.h"

namespace cmpg {

struct AccessorValues {
    std::uint32_t count = 0, components = 0;
    std::vector<float> values; // count * components, all finite

    float operator()(std::uint32_t i, std::uint32_t c) const { return values[std::size_t(i) * components + c]; }
};

// The accessor must have between `fewest` and `most` components. `use` is the place that names it, for messages.
AccessorValues readAccessor(const GltfDocument& document, int accessor, const std::string& use, std::uint32_t fewest, std::uint32_t most);

// Vertex indices, each below `vertexCount`.
std::vector<std::uint32_t> readIndices(const GltfDocument& document, int accessor, const std::string& use, std::uint32_t vertexCount);

} // namespace cmpg

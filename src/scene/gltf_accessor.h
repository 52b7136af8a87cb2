// Numbers out of glTF accessors: any component type, normalised, strided, sparse; every bound checked.
#pragma once

#include "scene/gltf_document.h"

namespace cmpg {

struct AccessorValues {
    std::uint32_t count = 0, components = 0;
    std::vector<float> values; // count * components, all finite

    float operator()(std::uint32_t i, std::uint32_t c) const { return values[std::size_t(i) * components + c]; }
};

// Number of elements, without reading them.
std::uint32_t accessorCount(const GltfDocument& document, const JsonView& reference);

// `reference` holds the accessor's index. It must have between `fewest` and `most` components.
AccessorValues readAccessor(GltfDocument& document, const JsonView& reference, std::uint32_t fewest, std::uint32_t most);

// Vertex indices, each below `vertexCount`.
std::vector<std::uint32_t> readIndices(GltfDocument& document, const JsonView& reference, std::uint32_t vertexCount);

} // namespace cmpg

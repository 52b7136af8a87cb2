// Numbers out of glTF accessors: any component type, normalised, strided, sparse; every bound checked.
#include "scene/gltf/accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cmpg {
namespace {

// An accessor without a buffer view costs no bytes in the file, so its size must be bounded by decree.
constexpr std::uint32_t kMaxCountWithoutData = 1u << 24;

// `count` elements of a buffer view; without one (bytes empty) all zero.
struct Elements {
    std::span<const std::uint8_t> bytes;
    std::uint64_t stride = 0;
    int type = TINYGLTF_COMPONENT_TYPE_FLOAT;
    bool normalized = false;

    template <class T> T load(std::uint64_t i, std::uint32_t c) const {
        T v;
        std::memcpy(&v, bytes.data() + i * stride + c * sizeof(T), sizeof(T));
        return v;
    }
    std::uint32_t integer(std::uint64_t i) const {
        if (bytes.empty()) return 0;
        if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return load<std::uint8_t>(i, 0);
        if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return load<std::uint16_t>(i, 0);
        return load<std::uint32_t>(i, 0);
    }
    float real(std::uint64_t i, std::uint32_t c) const {
        if (bytes.empty()) return 0;
        const auto scaled = [&](float v, float largest) { return normalized ? std::max(v / largest, -1.0f) : v; };
        switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE: return scaled(load<std::int8_t>(i, c), 127);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return scaled(load<std::uint8_t>(i, c), 255);
        case TINYGLTF_COMPONENT_TYPE_SHORT: return scaled(load<std::int16_t>(i, c), 32767);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return scaled(load<std::uint16_t>(i, c), 65535);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return scaled(float(load<std::uint32_t>(i, c)), 4294967295.0f);
        default: return load<float>(i, c);
        }
    }
};

// Where elements start: an accessor or a part of a sparse one.
struct Origin {
    int bufferView;
    std::size_t byteOffset;
    std::string place; // for messages
};

Elements open(const GltfDocument& document, const Origin& origin, std::uint32_t components, int type, std::uint32_t count) {
    Elements e;
    e.type = type;
    if (origin.bufferView < 0) {
        if (count > kMaxCountWithoutData)
            document.at(origin.place + ".count").fail("is " + std::to_string(count) + ", without data for so many elements");
        return e;
    }
    const std::uint64_t size = std::uint64_t(tinygltf::GetComponentSizeInBytes(std::uint32_t(type))) * components;
    const std::uint64_t stride = document.model().bufferViews[std::size_t(origin.bufferView)].byteStride;
    e.stride = stride ? stride : size;
    if (e.stride < size)
        document.at("bufferViews[" + std::to_string(origin.bufferView) + "].byteStride")
            .fail("is " + std::to_string(e.stride) + ", but an element of " + origin.place + " has " + std::to_string(size) + " bytes");
    const std::span<const std::uint8_t> bytes = document.bufferView(origin.bufferView);
    const std::uint64_t end = origin.byteOffset + (count ? (count - 1) * e.stride + size : 0);
    if (end > bytes.size())
        document.at(origin.place).fail("reaches to byte " + std::to_string(end) + " of a buffer view of " + std::to_string(bytes.size()));
    e.bytes = bytes.subspan(origin.byteOffset);
    return e;
}

std::string placeOf(int accessor) { return "accessors[" + std::to_string(accessor) + "]"; }

bool isUnsigned(int type) {
    return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
           type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

} // namespace

AccessorValues readAccessor(const GltfDocument& document, int index, const std::string& use, std::uint32_t fewest, std::uint32_t most) {
    const tinygltf::Accessor& accessor = document.model().accessors[std::size_t(index)];
    const std::string place = placeOf(index);
    AccessorValues out;
    out.count = std::uint32_t(accessor.count);
    out.components = std::uint32_t(tinygltf::GetNumComponentsInType(std::uint32_t(accessor.type)));
    if (out.components < fewest || out.components > most || accessor.type == TINYGLTF_TYPE_MAT2)
        document.at(place + ".type").fail("does not suit " + use);
    Elements base = open(document, {accessor.bufferView, accessor.byteOffset, place}, out.components, accessor.componentType, out.count);
    base.normalized = accessor.normalized;
    out.values.resize(std::size_t(out.count) * out.components);
    const auto copy = [&](const Elements& from, std::uint32_t source, std::uint32_t target) {
        for (std::uint32_t c = 0; c < out.components; ++c) {
            const float v = from.real(source, c);
            if (!std::isfinite(v))
                document.at(place + " (" + use + ")")
                    .fail("is not finite at element " + std::to_string(target),
                          "the exporter divided by zero, or the data is damaged", "repair the mesh and export it again");
            out.values[std::size_t(target) * out.components + c] = v;
        }
    };
    for (std::uint32_t i = 0; i < out.count; ++i) copy(base, i, i);

    const auto& sparse = accessor.sparse;
    if (!sparse.isSparse) return out;
    const auto count = std::uint32_t(sparse.count);
    if (count > out.count) document.at(place + ".sparse.count").fail("is more than the accessor has elements");
    const Origin where{sparse.indices.bufferView, std::size_t(sparse.indices.byteOffset), place + ".sparse.indices"};
    const Origin what{sparse.values.bufferView, std::size_t(sparse.values.byteOffset), place + ".sparse.values"};
    const Elements places = open(document, where, 1, sparse.indices.componentType, count);
    Elements values = open(document, what, out.components, accessor.componentType, count);
    values.normalized = base.normalized;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t target = places.integer(i);
        if (target >= out.count)
            document.at(where.place).fail("names element " + std::to_string(target) + " of " + std::to_string(out.count));
        copy(values, i, target);
    }
    return out;
}

std::vector<std::uint32_t> readIndices(const GltfDocument& document, int index, const std::string& use, std::uint32_t vertexCount) {
    const tinygltf::Accessor& accessor = document.model().accessors[std::size_t(index)];
    const std::string place = placeOf(index);
    if (accessor.type != TINYGLTF_TYPE_SCALAR) document.at(place + ".type").fail("must be SCALAR for indices");
    if (!isUnsigned(accessor.componentType)) document.at(place + ".componentType").fail("is not an unsigned integer type");
    if (accessor.sparse.isSparse) document.at(place + ".sparse").fail("is not supported for indices");
    const Elements elements =
        open(document, {accessor.bufferView, accessor.byteOffset, place}, 1, accessor.componentType, std::uint32_t(accessor.count));
    std::vector<std::uint32_t> out(accessor.count);
    for (std::uint32_t i = 0; i < out.size(); ++i) {
        out[i] = elements.integer(i);
        if (out[i] >= vertexCount)
            document.at(place + " (" + use + ")").fail("names vertex " + std::to_string(out[i]) + " at place " + std::to_string(i) +
                                                       ", but there are " + std::to_string(vertexCount));
    }
    return out;
}

} // namespace cmpg

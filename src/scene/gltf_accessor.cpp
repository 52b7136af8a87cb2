// Numbers out of glTF accessors: any component type, normalised, strided, sparse; every bound checked.
#include "scene/gltf_accessor.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cmpg {
namespace {

// An accessor without a buffer view costs no bytes in the file, so its size must be bounded by decree.
constexpr std::uint32_t kMaxCountWithoutData = 1u << 24;
constexpr std::uint32_t kMaxCount = 1u << 30;

enum ComponentType : std::uint32_t { Byte = 5120, UnsignedByte, Short, UnsignedShort, UnsignedInt = 5125, Float };

std::uint32_t componentSize(const JsonView& type) {
    switch (type.integer(0, 65535)) {
    case Byte:
    case UnsignedByte: return 1;
    case Short:
    case UnsignedShort: return 2;
    case UnsignedInt:
    case Float: return 4;
    default: type.fail("is not a component type of glTF");
    }
}

std::uint32_t componentCount(const JsonView& type) {
    const std::string name = type.string();
    if (name == "SCALAR") return 1;
    if (name.size() == 4 && name.rfind("VEC", 0) == 0 && name[3] >= '2' && name[3] <= '4') return std::uint32_t(name[3] - '0');
    type.fail("is \"" + name + "\"; expected are SCALAR, VEC2, VEC3 or VEC4");
}

// `count` elements of a buffer view; without one (bytes empty) all zero.
struct Elements {
    std::span<const std::uint8_t> bytes;
    std::uint64_t stride = 0;
    std::uint32_t type = Float, components = 1;
    bool normalized = false;

    template <class T> T load(std::uint64_t i, std::uint32_t c) const {
        T v;
        std::memcpy(&v, bytes.data() + i * stride + c * sizeof(T), sizeof(T));
        return v;
    }
    std::uint32_t integer(std::uint64_t i) const {
        if (bytes.empty()) return 0;
        if (type == UnsignedByte) return load<std::uint8_t>(i, 0);
        if (type == UnsignedShort) return load<std::uint16_t>(i, 0);
        return load<std::uint32_t>(i, 0);
    }
    float real(std::uint64_t i, std::uint32_t c) const {
        if (bytes.empty()) return 0;
        const auto scaled = [&](float v, float largest) { return normalized ? std::max(v / largest, -1.0f) : v; };
        switch (type) {
        case Byte: return scaled(load<std::int8_t>(i, c), 127);
        case UnsignedByte: return scaled(load<std::uint8_t>(i, c), 255);
        case Short: return scaled(load<std::int16_t>(i, c), 32767);
        case UnsignedShort: return scaled(load<std::uint16_t>(i, c), 65535);
        case UnsignedInt: return scaled(float(load<std::uint32_t>(i, c)), 4294967295.0f);
        default: return load<float>(i, c);
        }
    }
};

// Elements described by `owner` (an accessor or a part of a sparse one), read from `document`.
Elements open(GltfDocument& document, const JsonView& owner, std::uint32_t components, const JsonView& type, std::uint32_t count) {
    Elements e;
    e.type = std::uint32_t(type.integer(0, 65535));
    e.components = components;
    const std::uint64_t size = std::uint64_t(componentSize(type)) * components;
    const JsonView views = document.root()["bufferViews"];
    const auto index = owner["bufferView"].index(views.size(), "buffer view");
    if (!index) {
        if (count > kMaxCountWithoutData) owner["count"].fail("is " + std::to_string(count) + ", without data for so many elements");
        return e;
    }
    const std::span<const std::uint8_t> bytes = document.bufferView(*index);
    const JsonView stride = views.at(*index)["byteStride"];
    e.stride = stride.integer(size, 65536);
    if (e.stride < size) stride.fail("is " + std::to_string(e.stride) + ", but an element has " + std::to_string(size) + " bytes");
    const std::uint64_t offset = owner["byteOffset"].integer(0, kMaxFileBytes);
    const std::uint64_t end = offset + (count ? (count - 1) * e.stride + size : 0);
    if (end > bytes.size())
        owner.fail("reaches to byte " + std::to_string(end) + " of a buffer view of " + std::to_string(bytes.size()));
    e.bytes = bytes.subspan(offset);
    return e;
}

JsonView accessorOf(const GltfDocument& document, const JsonView& reference) {
    const JsonView accessors = document.root()["accessors"];
    const auto index = reference.index(accessors.size(), "accessor");
    if (!index) reference.fail("is missing");
    return accessors.at(*index);
}

bool isUnsigned(std::uint32_t type) { return type == UnsignedByte || type == UnsignedShort || type == UnsignedInt; }

} // namespace

std::uint32_t accessorCount(const GltfDocument& document, const JsonView& reference) {
    return std::uint32_t(accessorOf(document, reference)["count"].integer(0, kMaxCount));
}

AccessorValues readAccessor(GltfDocument& document, const JsonView& reference, std::uint32_t fewest, std::uint32_t most) {
    const JsonView accessor = accessorOf(document, reference);
    AccessorValues out;
    out.count = accessorCount(document, reference);
    out.components = componentCount(accessor["type"]);
    if (out.components < fewest || out.components > most)
        accessor["type"].fail("has " + std::to_string(out.components) + " components, which does not suit " + reference.place());
    Elements base = open(document, accessor, out.components, accessor["componentType"], out.count);
    base.normalized = accessor["normalized"].boolean(false);
    out.values.resize(std::size_t(out.count) * out.components);
    const auto copy = [&](const Elements& from, std::uint32_t source, std::uint32_t target) {
        for (std::uint32_t c = 0; c < out.components; ++c) {
            const float v = from.real(source, c);
            if (!std::isfinite(v))
                accessor.fail("(" + reference.place() + ") is not finite at element " + std::to_string(target),
                              "the exporter divided by zero, or the data is damaged", "repair the mesh and export it again");
            out.values[std::size_t(target) * out.components + c] = v;
        }
    };
    for (std::uint32_t i = 0; i < out.count; ++i) copy(base, i, i);

    const JsonView sparse = accessor["sparse"];
    if (!sparse.exists()) return out;
    const auto count = std::uint32_t(sparse["count"].integer(0, out.count));
    const Elements places = open(document, sparse["indices"], 1, sparse["indices"]["componentType"], count);
    if (!isUnsigned(places.type)) sparse["indices"]["componentType"].fail("is not an unsigned integer type");
    Elements values = open(document, sparse["values"], out.components, accessor["componentType"], count);
    values.normalized = base.normalized;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t place = places.integer(i);
        if (place >= out.count)
            sparse["indices"].fail("names element " + std::to_string(place) + " of " + std::to_string(out.count));
        copy(values, i, place);
    }
    return out;
}

std::vector<std::uint32_t> readIndices(GltfDocument& document, const JsonView& reference, std::uint32_t vertexCount) {
    const JsonView accessor = accessorOf(document, reference);
    const std::uint32_t count = accessorCount(document, reference);
    if (componentCount(accessor["type"]) != 1) accessor["type"].fail("must be SCALAR for indices");
    const Elements elements = open(document, accessor, 1, accessor["componentType"], count);
    if (!isUnsigned(elements.type)) accessor["componentType"].fail("is not an unsigned integer type");
    if (accessor["sparse"].exists()) accessor["sparse"].fail("is not supported for indices");
    std::vector<std::uint32_t> out(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        out[i] = elements.integer(i);
        if (out[i] >= vertexCount)
            accessor.fail("(" + reference.place() + ") names vertex " + std::to_string(out[i]) + " at place " + std::to_string(i) +
                          ", but there are " + std::to_string(vertexCount));
    }
    return out;
}

} // namespace cmpg

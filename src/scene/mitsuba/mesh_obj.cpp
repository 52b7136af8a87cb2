// Wavefront OBJ files, by tinyobjloader.
#include "scene/mitsuba/mesh.h"

#include <cstring>
#include <istream>
#include <limits>
#include <streambuf>
#include <tiny_obj_loader.h>
#include <unordered_map>

namespace cmpg {
namespace {

// A stream over bytes that are not copied.
class ByteBuffer : public std::streambuf {
  public:
    explicit ByteBuffer(const Bytes& bytes) {
        char* const begin = reinterpret_cast<char*>(const_cast<std::uint8_t*>(bytes.data())); // which is only read from
        setg(begin, begin, begin + bytes.size());
    }
};

struct Corner {
    int position, normal, uv;
    bool operator==(const Corner&) const = default;
};
struct CornerHash {
    std::size_t operator()(const Corner& c) const {
        std::uint64_t h = std::uint64_t(std::uint32_t(c.position)) * 0x9e3779b97f4a7c15u;
        h = (h ^ std::uint64_t(std::uint32_t(c.normal))) * 0xc2b2ae3d27d4eb4fu;
        h = (h ^ std::uint64_t(std::uint32_t(c.uv))) * 0x165667b19e3779f9u;
        return std::size_t(h ^ h >> 29);
    }
};

} // namespace

Mesh readObj(const Bytes& file, const std::string& name) {
    ByteBuffer buffer(file);
    std::istream stream(&buffer);
    tinyobj::attrib_t attributes;
    std::vector<tinyobj::shape_t> shapes;
    std::vector<tinyobj::material_t> materials;
    std::string warning, error;
    // Without a reader of materials no other file is opened. Polygons stay what they are: Mitsuba fans them, which tinyobjloader does not.
    const bool read = tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &stream, nullptr, false, false);
    const auto fail = [&](const std::string& what) { failMesh(name, what); };
    if (!read || !error.empty())
        fail("is no Wavefront OBJ: " + error.substr(0, error.find('\n')));

    Mesh mesh;
    const auto& v = attributes.vertices;
    const std::size_t positions = v.size() / 3, normals = attributes.normals.size() / 3, uvs = attributes.texcoords.size() / 2;
    const bool hasNormals = normals > 0, hasUvs = uvs > 0;
    std::unordered_map<Corner, std::uint32_t, CornerHash> vertices;
    vertices.reserve(positions * 2);
    const auto at = [](int index, std::size_t count) { return index >= 0 && std::size_t(index) < count; };
    const auto vertex = [&](const tinyobj::index_t& i) {
        if (!at(i.vertex_index, positions))
            fail("a face names a vertex that there is not");
        const Corner corner{i.vertex_index, at(i.normal_index, normals) ? i.normal_index : -1, at(i.texcoord_index, uvs) ? i.texcoord_index : -1};
        const auto [found, isNew] = vertices.try_emplace(corner, std::uint32_t(mesh.positions.size()));
        if (isNew) {
            const std::size_t p = std::size_t(corner.position) * 3, n = std::size_t(corner.normal) * 3, t = std::size_t(corner.uv) * 2;
            mesh.positions.emplace_back(v[p], v[p + 1], v[p + 2]);
            if (hasNormals)
                mesh.normals.push_back(corner.normal < 0 ? glm::vec3(0) : glm::vec3(attributes.normals[n], attributes.normals[n + 1], attributes.normals[n + 2]));
            if (hasUvs) // OBJ counts v from the bottom of pictures
                mesh.uvs.push_back(corner.uv < 0 ? glm::vec2(0) : glm::vec2(attributes.texcoords[t], 1 - attributes.texcoords[t + 1]));
        }
        return found->second;
    };
    std::vector<std::uint32_t> polygon;
    for (const tinyobj::shape_t& shape : shapes) {
        std::size_t first = 0;
        for (const std::size_t corners : shape.mesh.num_face_vertices) {
            if (corners > shape.mesh.indices.size() - first)
                fail("a face has fewer corners than it says");
            polygon.clear();
            for (std::size_t k = 0; k < corners && corners >= 3; ++k)
                polygon.push_back(vertex(shape.mesh.indices[first + k]));
            addPolygon(mesh, polygon);
            first += corners;
        }
        if (first != shape.mesh.indices.size()) // the library counts corners in a byte
            fail("a face has more than 255 corners");
    }
    requireFinite(mesh, name);
    return mesh;
}

} // namespace cmpg

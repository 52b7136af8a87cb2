// Triangles of a glTF scene in world space.
#include "scene/gltf/accessor.h"
#include "scene/gltf/load.h"
#include "scene/tangent_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace cmpg {
namespace {

// Corners of all triangles, three each, as indices of `vertices`: lists, strips and fans made alike.
std::vector<std::uint32_t> triangulate(std::vector<std::uint32_t> corners, int mode) {
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        corners.resize(corners.size() - corners.size() % 3);
        return corners;
    }
    std::vector<std::uint32_t> out;
    for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
        const std::size_t odd = i % 2;
        if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
            out.insert(out.end(), {corners[i], corners[i + 1 + odd], corners[i + 2 - odd]});
        else
            out.insert(out.end(), {corners[i + 1], corners[i + 2], corners[0]});
    }
    return out;
}

glm::vec4 colorAt(GltfLoad& load, const AccessorValues& colors, std::uint32_t i) {
    if (!colors.count) return glm::vec4(1);
    const glm::vec4 color(colors(i, 0), colors(i, 1), colors(i, 2), colors.components == 4 ? colors(i, 3) : 1.0f);
    const glm::vec4 clamped = glm::clamp(color, 0.0f, 1.0f);
    if (clamped != color) load.warn("vertex colours outside [0,1] were clamped");
    return clamped;
}

// Of a primitive whose file has none, one a corner, as an attribute TANGENT would have them.
std::vector<glm::vec4> makeTangents(const AccessorValues& positions, const AccessorValues& normals, const AccessorValues& uvs, const std::vector<std::uint32_t>& corners) {
    TangentMesh mesh;
    for (std::uint32_t i = 0; i < positions.count; ++i) {
        mesh.positions.emplace_back(positions(i, 0), positions(i, 1), positions(i, 2));
        mesh.normals.push_back(unitOrZero({normals(i, 0), normals(i, 1), normals(i, 2)}));
        mesh.uvs.emplace_back(uvs(i, 0), uvs(i, 1));
    }
    mesh.corners = corners;
    std::vector<glm::vec4> tangents = mikkTangents(mesh);
    for (glm::vec4& t : tangents) t.w = -t.w; // glTF's bitangents are along decreasing v, which runs down the image
    return tangents;
}

void addPrimitive(GltfLoad& load, std::uint64_t& read, const tinygltf::Primitive& primitive, const std::string& place,
                  const glm::dmat4& toWorld) {
    const tinygltf::Model& model = load.model;
    if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
        load.ignored.insert("points and lines");
        return;
    }
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) {
        load.ignored.insert("primitives without positions");
        return;
    }
    if (!primitive.targets.empty()) load.ignored.insert("morph targets");

    const auto countOf = [&](int accessor) { return std::uint32_t(model.accessors[std::size_t(accessor)].count); };
    const std::uint32_t count = countOf(position->second);
    const std::uint64_t corners = primitive.indices >= 0 ? countOf(primitive.indices) : count;
    const std::uint64_t most = load.options.maxTriangles;
    read += std::max(count, 1u);
    if (load.geometry.triangles() + corners / (primitive.mode == TINYGLTF_MODE_TRIANGLES ? 3 : 1) > most || read > 3 * most)
        load.document.at(place).fail("brings the scene to more than " + std::to_string(most) + " triangles or three times as many vertices",
                                     "the mesh is too detailed, or its counts are damaged", "simplify the scene");
    const auto attribute = [&](const std::string& name, std::uint32_t fewest, std::uint32_t widest) {
        const auto found = primitive.attributes.find(name);
        if (found == primitive.attributes.end()) return AccessorValues{};
        const std::string use = place + ".attributes." + name;
        if (countOf(found->second) != count)
            load.document.at(use).fail("has " + std::to_string(countOf(found->second)) + " elements for " + std::to_string(count) + " positions");
        return readAccessor(load.document, found->second, use, fewest, widest);
    };
    const AccessorValues positions = attribute("POSITION", 3, 3);
    std::vector<std::uint32_t> list;
    if (primitive.indices >= 0) {
        list = readIndices(load.document, primitive.indices, place + ".indices", count);
    } else {
        list.resize(count);
        for (std::uint32_t i = 0; i < count; ++i) list[i] = i;
    }
    list = triangulate(std::move(list), primitive.mode);

    const std::uint32_t material = primitive.material >= 0 ? std::uint32_t(primitive.material) : defaultMaterial(load);
    const Material& surface = load.scene.materials[material];
    const bool anisotropic = hasAnisotropy(surface);
    const AccessorValues normals = attribute("NORMAL", 3, 3);
    const auto texcoords = [&](std::uint32_t set) { return attribute("TEXCOORD_" + std::to_string(surface.texcoordSets[set]), 2, 2); };
    const AccessorValues uv0 = texcoords(0), uv1 = texcoords(1);
    const AccessorValues colors = attribute("COLOR_0", 3, 4);
    const bool needsTangents = (surface.hasNormalMap || hasClearcoatNormals(surface) || anisotropic) && normals.count;
    const AccessorValues tangents = needsTangents ? attribute("TANGENT", 4, 4) : AccessorValues{};
    const AccessorValues& uvs = tangentTexcoord(load.scene, surface) == 1 ? uv1 : uv0;
    const std::vector<glm::vec4> made = needsTangents && !tangents.count && uvs.count ? makeTangents(positions, normals, uvs, list) : std::vector<glm::vec4>();
    if (anisotropic && !tangents.count && !uv0.count && !uv1.count)
        load.warn(place + " has neither tangents nor texture coordinates: its anisotropy has an arbitrary direction");
    load.checkTexcoords(material, uv0.count > 0, uv1.count > 0);
    load.geometry.provide({normals.count > 0, uv0.count > 0, uv1.count > 0, tangents.count > 0 || !made.empty(), colors.count > 0});

    const glm::dmat3 linear(toWorld);
    const double sign = glm::determinant(linear) < 0 ? -1 : 1;
    const glm::dmat3 cofactor = cofactorMatrix(linear);

    const auto addVertex = [&](std::uint32_t i, const glm::vec4& tangent) {
        const glm::dvec3 local(positions(i, 0), positions(i, 1), positions(i, 2));
        const glm::dvec3 world(toWorld * glm::dvec4(local, 1));
        if (!fitsFloats(world))
            load.document.at(place + ".attributes.POSITION").fail("leaves the range of numbers at vertex " + std::to_string(i),
                                                                  "a node scales it too much", "check the transforms of the nodes");
        Vertex vertex;
        vertex.position = world;
        if (normals.count) vertex.normal = unitOrZero(sign * (cofactor * glm::dvec3(normals(i, 0), normals(i, 1), normals(i, 2))));
        if (uv0.count) vertex.uv0 = {uv0(i, 0), uv0(i, 1)};
        if (uv1.count) vertex.uv1 = {uv1(i, 0), uv1(i, 1)};
        vertex.color = colorAt(load, colors, i);
        const glm::vec3 t = unitOrZero(linear * glm::dvec3(tangent));
        if (t != glm::vec3(0)) vertex.tangent = glm::vec4(t, (tangent.w < 0 ? -1.0f : 1.0f) * float(sign));
        return load.geometry.add(vertex);
    };
    constexpr std::uint32_t kUnused = ~0u;
    std::vector<std::uint32_t> moved(count, kUnused); // of a vertex of the file in the scene; the first of several
    std::vector<glm::vec4> tangentOf(made.empty() ? 0 : count); // of that one
    std::map<std::pair<std::uint32_t, std::array<float, 4>>, std::uint32_t> split; // the others, by vertex of the file and tangent
    for (std::size_t c = 0; c < list.size(); ++c) {
        const std::uint32_t i = list[c];
        glm::vec4 tangent(0);
        if (!made.empty())
            tangent = made[c];
        else if (tangents.count)
            tangent = {tangents(i, 0), tangents(i, 1), tangents(i, 2), tangents(i, 3)};
        std::uint32_t* at = &moved[i];
        if (!made.empty() && *at == kUnused)
            tangentOf[i] = tangent;
        else if (!made.empty() && tangentOf[i] != tangent)
            at = &split.try_emplace({i, {tangent.x, tangent.y, tangent.z, tangent.w}}, kUnused).first->second;
        if (*at == kUnused) *at = addVertex(i, tangent);
        list[c] = *at;
    }
    load.unusedVertices += std::uint64_t(std::count(moved.begin(), moved.end(), kUnused));
    // A mirrored node turns its triangles inside out; swapping two corners turns them back.
    const std::size_t second = sign < 0 ? 2 : 1;
    for (std::size_t t = 0; t < list.size(); t += 3) load.geometry.add(Triangle{{list[t], list[t + second], list[t + 3 - second]}, material});
}

} // namespace

std::uint32_t defaultMaterial(const GltfLoad& load) { return std::uint32_t(load.model.materials.size()); }

bool usesDefaultMaterial(const GltfLoad& load) {
    return std::any_of(load.instances.begin(), load.instances.end(), [&](const NodeInstance& instance) {
        const int mesh = load.model.nodes[instance.node].mesh;
        if (mesh < 0) return false;
        const auto& primitives = load.model.meshes[std::size_t(mesh)].primitives;
        return std::any_of(primitives.begin(), primitives.end(), [](const tinygltf::Primitive& p) { return p.material < 0; });
    });
}

void loadGeometry(GltfLoad& load) {
    std::uint64_t read = 0; // vertices, used or not; a primitive counts as one at least, so that none comes for free
    for (const NodeInstance& instance : load.instances) {
        const tinygltf::Node& node = load.model.nodes[instance.node];
        if (node.mesh < 0) continue;
        if (node.skin >= 0) load.ignored.insert("skins");
        const auto& primitives = load.model.meshes[std::size_t(node.mesh)].primitives;
        for (std::size_t i = 0; i < primitives.size(); ++i) {
            const std::string place = "meshes[" + std::to_string(node.mesh) + "].primitives[" + std::to_string(i) + "]";
            addPrimitive(load, read, primitives[i], place, instance.toWorld);
        }
    }
    load.geometry.finish(load.scene);
}

} // namespace cmpg

// Meshes in Wavefront OBJ and PLY files.
#include "fuzz.h"
#include "scene/mitsuba/mesh.h"

#include <algorithm>

using namespace cmpg;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::accepts({ErrorKind::Input}, [&] {
        const bool ply = size >= 3 && std::equal(data, data + 3, "ply");
        Mesh mesh = (ply ? readPly : readObj)(Bytes(data, data + size), "mesh");
        fuzz::require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size(), "normals belong to all positions");
        fuzz::require(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size(), "texture coordinates belong to all positions");
        for (const glm::uvec3& t : mesh.triangles)
            for (int k = 0; k < 3; ++k)
                fuzz::require(t[k] < mesh.positions.size(), "triangles have corners");
        mesh.normals = smoothNormals(mesh.positions, mesh.triangles);
    });
    return 0;
}

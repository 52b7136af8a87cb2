// Other sizes of parameters.
#include "scene/parameter_size.h"

#include "base/error.h"
#include "scene/resample.h"

#include <algorithm>
#include <string>

namespace cmpg {
namespace {

// A triangle with a material that reads the parameter, and an area in its texture coordinates.
bool hasTexcoords(const Scene& scene, std::uint32_t parameter) {
    std::vector<bool> reads(scene.materials.size());
    for (std::size_t m = 0; m < reads.size(); ++m)
        reads[m] = std::find(scene.materials[m].parameters.begin(), scene.materials[m].parameters.end(), parameter) != scene.materials[m].parameters.end();
    for (std::size_t m = 0; m < reads.size(); ++m)
        if (const std::uint32_t other = scene.materials[m].blendWith; other != kNoMaterial && reads[other])
            reads[m] = true;
    const Geometry& geometry = scene.geometry;
    const std::vector<glm::vec2>& uv = scene.parameters[parameter].texcoord == 1 ? geometry.uv1 : geometry.uv0;
    if (uv.empty())
        return false;
    return std::any_of(geometry.triangles.begin(), geometry.triangles.end(), [&](const Triangle& t) {
        const glm::dvec2 a = uv[t.vertices[0]], b = glm::dvec2(uv[t.vertices[1]]) - a, c = glm::dvec2(uv[t.vertices[2]]) - a;
        return reads[t.material] && b.x * c.y != b.y * c.x;
    });
}

[[noreturn]] void refuse(const Parameter& parameter, const std::string& cause, const std::string& remedy) {
    throw Error(ErrorKind::Usage, parameter.name + " takes no texture of another size", cause, remedy);
}

void requireTexture(const Scene& scene, std::uint32_t index) {
    const Parameter& parameter = scene.parameters[index];
    if (parameter.kind == SlotKind::Radiance) {
        if (!parameter.textured)
            refuse(parameter, "the environment has one colour", "give the scene a picture of its surroundings of that size");
        return;
    }
    if (parameter.kind == SlotKind::Anisotropy)
        refuse(parameter, "its texture has directions, too", "scale the image in the scene's file");
    if (parameter.kind == SlotKind::Normal && !parameter.textured)
        refuse(parameter, "the material has no normal map", "give it one, of the colour 128, 128, 255, in the scene's file");
    if (!hasTexcoords(scene, index))
        refuse(parameter, "the meshes of this material have no texture coordinates", "unwrap them in the program that made the scene");
}

} // namespace

void resize(Scene& scene, std::uint32_t index, std::uint32_t width, std::uint32_t height) {
    Parameter& parameter = scene.parameters.at(index);
    if (width < 1 || height < 1 || width > kMostTexels || height > kMostTexels)
        throw Error(ErrorKind::Usage, std::to_string(width) + "x" + std::to_string(height) + " is no size of a texture", "",
                    "give from 1 to " + std::to_string(kMostTexels) + " texels along each edge");
    if (width == parameter.width && height == parameter.height)
        return;
    requireTexture(scene, index);
    parameter.materialise();
    parameter.values = resampled(parameter.values, parameter.channels, {parameter.width, parameter.height}, {width, height}, parameter.wrapU, parameter.wrapV);
    if (parameter.kind != SlotKind::Normal) // whose length says nothing
        for (float& value : parameter.values)  // rounding may leave the range
            value = std::clamp(value, parameter.lowest(), parameter.highest());
    parameter.width = width;
    parameter.height = height;
    parameter.textured = true;
}

} // namespace cmpg

// How fine a texture is in a picture.
#include "optimize/texel_footprint.h"

#include "optimize/ordered_sum.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cmpg {
namespace {

constexpr std::size_t kMostTriangles = 1 << 21; // in all pictures
constexpr std::size_t kTrianglesAtOnce = 1 << 12;

struct Corner {
    glm::vec4 place; // CameraRays::project()
    glm::vec2 texel;
};
using Polygon = std::vector<Corner>;

// Of the part where inside(corner), linear in its place, is not below 0 (Sutherland and Hodgman 1974).
template <class Inside> void clip(Polygon& polygon, Polygon& other, const Inside& inside) {
    other.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const float from = inside(a.place), to = inside(b.place);
        if (from >= 0)
            other.push_back(a);
        if ((from >= 0) != (to >= 0)) {
            const float t = from / (from - to);
            other.push_back({glm::mix(a.place, b.place, t), glm::mix(a.texel, b.texel, t)});
        }
    }
    polygon.swap(other);
}

struct Areas {
    double texels = 0, picture = 0; // the whole picture is 4
    Areas& operator+=(const Areas& other) {
        texels += other.texels;
        picture += other.picture;
        return *this;
    }
};

// Of what is within the picture.
Areas areasOf(Polygon& polygon, Polygon& other, float nearest) {
    clip(polygon, other, [&](const glm::vec4& p) { return p.z - nearest; });
    for (const int axis : {0, 1})
        for (const float sign : {-1.f, 1.f})
            clip(polygon, other, [&](const glm::vec4& p) { return p.w - sign * p[axis]; });
    const auto area = [&](const auto& at) {
        double sum = 0;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const glm::dvec2 a = at(polygon[i]), b = at(polygon[(i + 1) % polygon.size()]);
            sum += a.x * b.y - a.y * b.x;
        }
        return 0.5 * std::abs(sum);
    };
    return {area([](const Corner& c) { return glm::dvec2(c.texel); }), area([](const Corner& c) { return glm::dvec2(c.place) / double(c.place.w); })};
}

} // namespace

double texelsPerPixel(const Scene& scene, std::uint32_t parameter, std::span<const CameraRays> pictures) {
    const Parameter& texture = scene.parameters[parameter];
    const Geometry& g = scene.geometry;
    const std::vector<glm::vec2>& uv = texture.texcoord == 0 ? g.uv0 : g.uv1;
    if (texture.kind == SlotKind::Radiance || texture.entries() == texture.channels || uv.empty())
        return 0;
    const auto reads = [&](std::uint32_t material) {
        return material != kNoMaterial && scene.materials[material].parameters[std::size_t(texture.kind)] == parameter;
    };
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 0; i < g.triangles.size(); ++i)
        if (const std::uint32_t material = g.triangles[i].material; reads(material) || reads(scene.materials[material].blendWith))
            triangles.push_back(std::uint32_t(i));
    const std::size_t stride = 1 + triangles.size() * pictures.size() / kMostTriangles;
    const glm::vec2 size(texture.width, texture.height);
    double texels = 0, pixels = 0;
    for (const CameraRays& picture : pictures) {
        const Areas areas = orderedSum<Areas>((triangles.size() + stride - 1) / stride, kTrianglesAtOnce, [&](std::size_t begin, std::size_t end) {
            Areas sum;
            Polygon polygon, other;
            for (std::size_t i = begin; i < end; ++i) {
                polygon.clear();
                float farthest = 0;
                for (const std::uint32_t v : g.triangles[triangles[i * stride]].vertices) {
                    polygon.push_back({picture.project(g.positions[v]), size * (texture.uvTransform * glm::vec3(uv[v], 1))});
                    farthest = std::max(farthest, std::abs(polygon.back().place.z));
                }
                sum += areasOf(polygon, other, 1e-6f * farthest);
            }
            return sum;
        });
        texels += areas.texels;
        pixels += areas.picture / 4 * picture.pixels();
    }
    const double square = texels / pixels;
    return std::isfinite(square) ? std::sqrt(square) : 0;
}

} // namespace cmpg

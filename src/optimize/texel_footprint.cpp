// How fine a texture is in a picture.
#include "optimize/texel_footprint.h"

#include "optimize/ordered_sum.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
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

constexpr int kOctaves = 24; // of texels in a pixel

struct Areas {
    double texels = 0, pixels = 0;
    std::array<double, kOctaves> byLeast{}; // of the texels, by the logarithm to base 2 of how many lie along the shorter side of what a pixel covers there
    Areas& operator+=(const Areas& other) {
        texels += other.texels;
        pixels += other.pixels;
        for (std::size_t k = 0; k < byLeast.size(); ++k)
            byLeast[k] += other.byLeast[k];
        return *this;
    }
};

// How texels follow from places in the picture, over a triangle in perspective: texel = (N s) / (d s), with s = (x, y, 1).
class TexelMap {
  public:
    explicit TexelMap(const Polygon& triangle) {
        glm::dmat3 places, texels;
        for (int i = 0; i < 3; ++i) {
            const glm::dvec4 place(triangle[std::size_t(i)].place);
            places[i] = {place.x, place.y, place.w};
            texels[i] = glm::dvec3(triangle[std::size_t(i)].texel, 1);
        }
        map_ = texels * glm::inverse(places);
    }
    // The shorter side of what a pixel of `size`, in the picture, covers about a corner of it: the smaller singular value of the derivative. 0 where there is none.
    double shorterSide(const Corner& corner, const glm::dvec2& size) const {
        glm::dmat2 j; // columns: along x, along y
        for (int axis = 0; axis < 2; ++axis)
            for (int k = 0; k < 2; ++k)
                j[axis][k] = double(corner.place.w) * (map_[axis][k] - double(corner.texel[k]) * map_[axis][2]) * size[axis];
        const double squares = glm::dot(j[0], j[0]) + glm::dot(j[1], j[1]), determinant = std::abs(glm::determinant(j));
        const double longer = std::sqrt(0.5 * (squares + std::sqrt(std::max(0.0, squares * squares - 4 * determinant * determinant))));
        return longer > 0 && std::isfinite(longer) ? determinant / longer : 0;
    }

  private:
    glm::dmat3 map_; // rows: N, d
};

// Of what is within the picture of a triangle.
Areas areasOf(Polygon& polygon, Polygon& other, float nearest, const CameraRays& picture) {
    const TexelMap map(polygon);
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
    Areas areas{area([](const Corner& c) { return glm::dvec2(c.texel); }), area([](const Corner& c) { return glm::dvec2(c.place) / double(c.place.w); })};
    areas.pixels *= picture.pixels() / 4; // of the picture, which is from -1 to 1
    double least = std::exp2(kOctaves - 1);
    for (const Corner& corner : polygon)
        least = std::min(least, map.shorterSide(corner, 2.0 / picture.size()));
    areas.byLeast[least > 1 ? std::size_t(std::log2(least)) : 0] = areas.texels;
    return areas;
}

// The least that all but a fiftieth of the texels have.
double leastOf(const Areas& areas) {
    constexpr double kLeft = 0.02;
    std::size_t octave = 0;
    for (double texels = areas.byLeast[0]; octave + 1 < kOctaves && texels <= kLeft * areas.texels;)
        texels += areas.byLeast[++octave];
    return octave > 0 && areas.texels > 0 ? std::exp2(double(octave)) : 0;
}

} // namespace

TexelFootprint texelFootprint(const Scene& scene, std::uint32_t parameter, std::span<const CameraRays> pictures) {
    const Parameter& texture = scene.parameters[parameter];
    const Geometry& g = scene.geometry;
    const std::vector<glm::vec2>& uv = texture.texcoord == 0 ? g.uv0 : g.uv1;
    if (texture.kind == SlotKind::Radiance || texture.entries() == texture.channels || uv.empty())
        return {};
    const auto reads = [&](std::uint32_t material) {
        return material != kNoMaterial && scene.materials[material].parameters[std::size_t(texture.kind)] == parameter;
    };
    std::vector<std::uint32_t> triangles;
    for (std::size_t i = 0; i < g.triangles.size(); ++i)
        if (const std::uint32_t material = g.triangles[i].material; reads(material) || reads(scene.materials[material].blendWith))
            triangles.push_back(std::uint32_t(i));
    const std::size_t stride = 1 + triangles.size() * pictures.size() / kMostTriangles;
    const glm::vec2 size(texture.width, texture.height);
    Areas all;
    for (const CameraRays& picture : pictures) {
        all += orderedSum<Areas>((triangles.size() + stride - 1) / stride, kTrianglesAtOnce, [&](std::size_t begin, std::size_t end) {
            Areas sum;
            Polygon polygon, other;
            for (std::size_t i = begin; i < end; ++i) {
                polygon.clear();
                float farthest = 0;
                for (const std::uint32_t v : g.triangles[triangles[i * stride]].vertices) {
                    polygon.push_back({picture.project(g.positions[v]), size * (texture.uvTransform * glm::vec3(uv[v], 1))});
                    farthest = std::max(farthest, std::abs(polygon.back().place.z));
                }
                sum += areasOf(polygon, other, 1e-6f * farthest, picture);
            }
            return sum;
        });
    }
    const double square = all.texels / all.pixels;
    return {std::isfinite(square) ? std::sqrt(square) : 0, leastOf(all)};
}

double sampleShare(std::span<const TexelFootprint> footprints) {
    constexpr double kPixels = 4, kLeast = 0.25;
    double share = footprints.empty() ? 1 : kLeast;
    for (const TexelFootprint& footprint : footprints)
        share = std::max(share, footprint.mean > 0 ? std::min(1.0, kPixels * footprint.mean * footprint.mean) : 1.0);
    return share;
}

} // namespace cmpg

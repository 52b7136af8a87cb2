// Rays of a camera and what they hit first, on the host.
#include "scene/camera_ray.h"

#include "base/parallel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

namespace cmpg {
namespace {

float wrapped(float t, Wrap wrap) {
    if (wrap == Wrap::Clamp)
        return std::clamp(t, 0.f, 1.f);
    if (wrap == Wrap::Repeat)
        return t - std::floor(t);
    const float twice = t - 2 * std::floor(0.5f * t);
    return twice > 1 ? 2 - twice : twice;
}

float alphaAt(const AlphaTexture& texture, glm::vec2 uv) {
    uv = texture.uvTransform * glm::vec3(uv, 1);
    const auto texel = [](float t, std::uint32_t size) { return std::min(std::uint32_t(std::max(t, 0.f) * float(size)), size - 1); };
    const std::uint32_t x = texel(wrapped(uv.x, texture.wrapU), texture.width), y = texel(wrapped(uv.y, texture.wrapV), texture.height);
    return float(texture.alpha[std::size_t(y) * texture.width + x]) / 255.f;
}

bool isCutOut(const Scene& scene, const Triangle& triangle, glm::vec3 b) {
    const Material& material = scene.materials[triangle.material];
    if (!material.alphaMask)
        return false;
    const auto interpolate = [&](const auto& attribute) {
        return b.x * attribute[triangle.vertices[0]] + b.y * attribute[triangle.vertices[1]] + b.z * attribute[triangle.vertices[2]];
    };
    const Geometry& g = scene.geometry;
    float alpha = material.alphaFactor;
    if (material.alphaTexture != ~0u) {
        const AlphaTexture& texture = scene.alphaTextures[material.alphaTexture];
        const std::vector<glm::vec2>& uv = texture.texcoord == 0 ? g.uv0 : g.uv1;
        alpha *= alphaAt(texture, uv.empty() ? glm::vec2(0) : interpolate(uv));
    }
    if (!g.colors.empty())
        alpha *= interpolate(g.colors).w;
    return alpha < (material.coverage ? 0.5f : material.alphaCutoff);
}

struct Nearest {
    float distance = std::numeric_limits<float>::infinity();
    std::uint32_t triangle = ~0u;
};

// Möller and Trumbore 1997.
void intersect(const Scene& scene, const CameraRays::Ray& ray, std::uint32_t index, Nearest& nearest) {
    const Triangle& triangle = scene.geometry.triangles[index];
    const auto& p = scene.geometry.positions;
    const glm::vec3 a = p[triangle.vertices[0]], ab = p[triangle.vertices[1]] - a, ac = p[triangle.vertices[2]] - a;
    const glm::vec3 h = glm::cross(ray.direction, ac);
    const float determinant = glm::dot(ab, h);
    if (determinant == 0)
        return;
    const glm::vec3 s = ray.origin - a, q = glm::cross(s, ab);
    const float u = glm::dot(s, h) / determinant, v = glm::dot(ray.direction, q) / determinant, t = glm::dot(ac, q) / determinant;
    if (!(u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < nearest.distance) || isCutOut(scene, triangle, {1 - u - v, u, v}))
        return;
    nearest = {t, index};
}

} // namespace

CameraRays::CameraRays(const Camera& c, int width, int height) : width_(width), height_(height), orthographic_(c.orthographic) {
    const glm::mat3 axes(c.toWorld);
    const float halfHeight = orthographic_ ? c.ymag : std::tan(0.5f * c.yfov);
    origin_ = glm::vec3(c.toWorld[3]);
    right_ = glm::normalize(axes[0]) * halfHeight * float(width_) / float(height_);
    up_ = glm::normalize(axes[1]) * halfHeight;
    forward_ = -glm::normalize(axes[2]);
    (orthographic_ ? origin_ : forward_) += halfHeight * (c.center.x * glm::normalize(axes[0]) + c.center.y * glm::normalize(axes[1]));
    toPicture_ = glm::inverse(glm::mat3(right_, up_, forward_));
}

CameraRays::Ray CameraRays::at(float x, float y) const {
    const glm::vec3 across = (2 * x / float(width_) - 1) * right_ + (1 - 2 * y / float(height_)) * up_;
    if (orthographic_)
        return {origin_ + across, forward_};
    return {origin_, glm::normalize(across + forward_)};
}

glm::vec4 CameraRays::project(const glm::vec3& point) const {
    const glm::vec3 place = toPicture_ * (point - origin_);
    return {place, orthographic_ ? 1 : place.z};
}

std::optional<SurfaceHit> castRay(const Scene& scene, const CameraRays::Ray& ray) {
    Nearest best;
    std::mutex mutex;
    parallelFor(scene.geometry.triangles.size(), 1 << 16, [&](std::size_t begin, std::size_t end) {
        Nearest nearest;
        for (std::size_t i = begin; i < end; ++i)
            intersect(scene, ray, std::uint32_t(i), nearest);
        const std::lock_guard lock(mutex);
        if (nearest.distance < best.distance || (nearest.distance == best.distance && nearest.triangle < best.triangle))
            best = nearest;
    });
    if (best.triangle == ~0u)
        return {};
    const auto& p = scene.geometry.positions;
    const auto& v = scene.geometry.triangles[best.triangle].vertices;
    glm::vec3 normal = glm::normalize(glm::cross(p[v[1]] - p[v[0]], p[v[2]] - p[v[0]]));
    if (glm::dot(normal, ray.direction) > 0)
        normal = -normal;
    return SurfaceHit{best.distance, best.triangle, ray.origin + best.distance * ray.direction, normal};
}

} // namespace cmpg

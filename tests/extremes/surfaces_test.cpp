// Rays that leave a surface: how many meet it again, at all scales and distances from the origin; light that grazes its own plane.
#include "support/generated_geometry.h"
#include "support/render_fixture.h"
#include "support/scene_builder.h"
#include "worst.h"

#include <glm/gtc/matrix_transform.hpp>
#include <sstream>

namespace cmpg::test {
namespace {

Parameter& valueOf(Scene& scene, std::uint32_t material, SlotKind kind) { return scene.parameters[scene.materials[material].parameters[std::size_t(kind)]]; }

// Rays of a pass over a convex body with that many segments: no light is sampled, so each is a camera ray or drawn.
std::uint64_t raysOf(const Scene& scene, std::uint32_t depth, int edge, std::uint32_t spp) {
    RenderConfig config;
    config.maxDepth = depth;
    config.lightSampling = false;
    Bench s(scene, {}, config);
    s.renderer->render(viewOf(s.scene, edge, edge), spp, {3, 0, 0}, s.plan, &s.result);
    return s.result.rays;
}

// From a convex body a drawn ray leads nowhere. Passes of two and of three segments trace the same rays, and the third segments of those
// that met the body again.
TEST(ExtremeSurfaces, ConvexBodiesDoNotMeetThemselves) {
    Worst worst("surface | rays that meet the convex body they leave, share | scene 1e-4 to 1e6 units; offset 0 to 8 diagonals; chalk and mirror", "0", 1e-6);
    constexpr int kEdge = 256;
    constexpr std::uint32_t kSamples = 16;
    struct Place {
        float scale, offset, roughness, metallic;
    };
    for (const Place& at : {Place{1e-4f, 0, 1, 0}, Place{1, 0, 0, 1}, Place{1, 8, 1, 0}, Place{1e3f, -8, 0.3f, 1}, Place{1e6f, 0, 1, 0}, Place{1e6f, 8, 0, 1}}) {
        SceneBuilder b;
        const std::uint32_t m = b.material("body", 0.8f, 0);
        valueOf(b.scene, m, SlotKind::Roughness).values = {at.roughness};
        valueOf(b.scene, m, SlotKind::Metallic).values = {at.metallic};
        const glm::vec3 center = 3 * at.offset * at.scale * glm::vec3(1, -0.5f, 0.3f);
        generated::addSphere(b.scene.geometry, center, at.scale * glm::vec3(1, 1.5f, 0.7f), 24);
        b.scene.geometry.uv0.assign(b.scene.geometry.positions.size(), {});
        Camera camera; // the whole body, its rim as well
        camera.orthographic = true;
        camera.ymag = 1.2f * at.scale;
        camera.toWorld = glm::translate(glm::mat4(1), center + glm::vec3(0, 0, 4 * at.scale));
        b.scene.cameras = {camera};
        Parameter sky; // for which last rays are sent
        sky.kind = SlotKind::Radiance;
        sky.width = 4;
        sky.height = 2;
        sky.textured = true;
        sky.values.assign(sky.entries(), 1.0f);
        b.scene.environment = Environment{std::uint32_t(b.scene.parameters.size())};
        b.scene.parameters.push_back(sky);
        const double paths = double(kEdge) * kEdge * kSamples;
        const std::uint64_t two = raysOf(b.scene, 2, kEdge, kSamples), three = raysOf(b.scene, 3, kEdge, kSamples);
        const auto where = [&] {
            std::ostringstream s;
            s << "scale " << at.scale << " offset " << at.offset << " roughness " << at.roughness << ": " << three - two << " of " << double(two) - paths;
            return s.str();
        };
        EXPECT_GT(double(two), 1.5 * paths) << "most camera rays meet the body";
        worst.add(double(three - two) / (double(two) - paths), where);
    }
}

// A sun that grazes a plane: no sample may be in the plane's own shadow. With one light without extent a pixel is exact.
TEST(ExtremeSurfaces, SunGrazingAPlane) {
    Worst worst("surface | radiance of a plane under a grazing sun | 0.1 to 89.9999 degrees; scene 1e-4 to 1e6 units", "albedo cos / pi", 1e-4);
    struct Case {
        float scale;
        double degrees;
    };
    for (const auto& [scale, degrees] : {Case{1, 0.1}, Case{1, 60}, Case{1, 89.99}, Case{1, 89.9999}, Case{1e-4f, 89.9999}, Case{1e6f, 89.9999}}) {
        SceneBuilder b;
        const std::uint32_t m = b.material("plane", 0.5f, 0);
        // Uneven triangles, askew in space.
        const glm::dmat3 turn(glm::rotate(glm::dmat4(1), 0.7, glm::normalize(glm::dvec3(1, 2, 0.5))));
        const glm::vec3 x(double(scale) * turn[0]), y(double(scale) * turn[1]);
        b.quad(m, -1.0f * x - 1.3f * y, 2.1f * x, 2.7f * y);
        Camera camera;
        camera.orthographic = true;
        camera.ymag = 0.5f * scale;
        camera.toWorld = glm::mat4(glm::dmat4(turn));
        camera.toWorld[3] = glm::vec4(double(scale) * turn[2], 1);
        b.scene.cameras = {camera};
        // The normals the vertices have after rounding, as the device has them: rounded to float, which turns them by up to 1e-7.
        std::vector<glm::dvec3> normals;
        for (const Triangle& t : b.scene.geometry.triangles) {
            const glm::dvec3 p0(b.scene.geometry.positions[t.vertices[0]]), p1(b.scene.geometry.positions[t.vertices[1]]), p2(b.scene.geometry.positions[t.vertices[2]]);
            normals.emplace_back(glm::vec3(glm::normalize(glm::cross(p1 - p0, p2 - p0))));
        }
        const glm::dvec3 n = normals[0];
        const glm::dvec3 across = glm::normalize(glm::cross(n, glm::dvec3(0.2, 1, 0)));
        const double theta = degrees * glm::pi<double>() / 180;
        PunctualLight sun;
        sun.kind = PunctualLight::Kind::Directional;
        sun.direction = -(std::cos(theta) * n + std::sin(theta) * across);
        sun.intensity = glm::vec3(1e6f);
        b.scene.lights = {sun};
        Bench s(b.scene, {});
        const Image image = s.renderer->render(viewOf(s.scene, 8, 8), 16, {1, 0, 0}, s.plan, &s.result);
        const auto radiance = [&](const glm::dvec3& normal) { return 1e6 * 0.5 / glm::pi<double>() * -glm::dot(normal, glm::dvec3(sun.direction)); };
        for (const float v : image.values) {
            // A pixel on the diagonal shows both triangles.
            const double first = radiance(normals[0]), second = radiance(normals[1]);
            const double truth = std::clamp(double(v), std::min(first, second), std::max(first, second));
            const double error = std::abs(double(v) - truth) / truth;
            worst.add(error, [&] { return "scale " + std::to_string(scale) + " degrees " + std::to_string(degrees) + ": " + std::to_string(v); });
        }
    }
}

} // namespace
} // namespace cmpg::test

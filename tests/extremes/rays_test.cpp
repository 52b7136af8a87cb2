// Rays against triangles from 1e-4 to 1e6 units in size, far from the origin, thin, coplanar and touching; truth in double precision on
// the same float32 vertices.
#include "scene/gltf_writer.h"
#include "support/generated_geometry.h"
#include "support/render_fixture.h"
#include "support/tracer.h"
#include "worst.h"

#include <optional>
#include <sstream>

namespace cmpg::test {
namespace {

using generated::Random;

struct Corners {
    glm::dvec3 a, b, c;
};

Corners cornersOf(const Geometry& g, std::uint32_t triangle) {
    const auto& v = g.triangles[triangle].vertices;
    return {g.positions[v[0]], g.positions[v[1]], g.positions[v[2]]};
}

// Where a ray meets a triangle's plane, and how far inside the triangle: the distance to the nearest edge as the ray sees it,
// negative outside.
struct Meeting {
    double t, margin;
};
std::optional<Meeting> meet(const Corners& p, const glm::dvec3& origin, const glm::dvec3& direction) {
    const glm::dvec3 e1 = p.b - p.a, e2 = p.c - p.a, across = glm::cross(direction, e2);
    const double det = glm::dot(e1, across);
    if (det == 0) return {};
    const glm::dvec3 from = origin - p.a, q = glm::cross(from, e1);
    const double u = glm::dot(from, across) / det, v = glm::dot(direction, q) / det, t = glm::dot(e2, q) / det;
    if (t <= 0) return {};
    return Meeting{t, std::abs(det) * std::min({u / glm::length(e2), v / glm::length(e1), (1 - u - v) / glm::length(p.c - p.b)})};
}

// A ray's nearest meeting that is not outside by more than rounding in double.
double nearest(const Geometry& g, const gpu::Ray& ray) {
    double t = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < g.triangles.size(); ++i)
        if (const auto m = meet(cornersOf(g, i), glm::dvec3(ray.origin), glm::dvec3(ray.direction)); m && m->margin >= -1e-9 * m->t) t = std::min(t, m->t);
    return t;
}

double largestCoordinate(const Geometry& g) {
    double most = 0;
    for (const glm::vec3& p : g.positions) most = std::max({most, std::abs(double(p.x)), std::abs(double(p.y)), std::abs(double(p.z))});
    return most;
}

// Two errors of a hit as shares of the largest number involved: of the distance, across the triangle's plane; and of the point that the
// barycentrics lead to, off the ray.
struct HitErrors {
    double distance, point;
};
HitErrors errorsOf(const Geometry& g, std::uint32_t triangle, const gpu::Ray& ray, const gpu::Hit& hit, double t) {
    const Corners p = cornersOf(g, triangle);
    const glm::dvec3 origin(ray.origin), direction = glm::normalize(glm::dvec3(ray.direction));
    const glm::dvec3 normal = glm::normalize(glm::cross(p.b - p.a, p.c - p.a));
    const double size = largestCoordinate(g) + glm::length(origin) + t;
    // As shaders/scene/geometry.glsl has it.
    const auto& v = g.triangles[triangle].vertices;
    const glm::vec3 v0 = g.positions[v[0]], e1 = g.positions[v[1]] - v0, e2 = g.positions[v[2]] - v0;
    const glm::dvec3 point(v0 + hit.barycentrics.x * e1 + hit.barycentrics.y * e2);
    const glm::dvec3 off = point - origin;
    return {std::abs(double(hit.t) - t) * std::abs(glm::dot(normal, direction)) / size, glm::length(off - glm::dot(off, direction) * direction) / size};
}

// The geometry as the loader makes it of float32 vertices that far from the origin.
Geometry loadedAt(const Geometry& g, glm::dvec3 offset, Worst& moved) {
    GltfWriter w;
    std::vector<float> positions;
    for (const glm::vec3& p : g.positions)
        for (int c = 0; c < 3; ++c) positions.push_back(float(double(p[c]) + offset[c]));
    std::vector<std::uint16_t> indices;
    for (const Triangle& t : g.triangles)
        for (const std::uint32_t v : t.vertices) indices.push_back(std::uint16_t(v));
    w.json["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", w.floats(positions, 3)}}}, {"indices", w.indices(indices)}}}}}};
    w.json["nodes"] = {{{"mesh", 0}}};
    TempFolder folder;
    const Scene scene = loadScene(w.write(folder));
    const double size = largestCoordinate(scene.geometry);
    for (const glm::vec3& p : scene.geometry.positions) { // the loader numbers them anew
        double closest = std::numeric_limits<double>::infinity();
        for (std::size_t v = 0; v < positions.size(); v += 3)
            closest = std::min(closest, glm::length(glm::dvec3(p) + scene.center - glm::dvec3(positions[v], positions[v + 1], positions[v + 2])));
        moved.add(closest / size, [&] { return std::to_string(offset.x); });
    }
    return scene.geometry;
}

std::string place(double scale, double offset) {
    std::ostringstream s;
    s << "scale " << scale << " offset " << offset;
    return s.str();
}

// From inside a closed surface every ray must end, also those aimed at its edges and corners.
TEST(ExtremeRays, ScalesAndOffsets) {
    const std::string range = " | scene 1e-4 to 1e6 units, offset 0 to 1e5 units, rays at faces, edges, corners";
    Worst lost("ray | rays that leave a closed surface" + range, "0", 0), distance("ray | distance to the plane, per largest coordinate" + range, "float64", 1e-6);
    Worst point("ray | point by barycentrics, off the ray, per largest coordinate" + range, "float64", 1e-6);
    Worst moved("scene | vertices moved to the middle, per largest coordinate | offset 0 to 1e5 units", "float64", 1e-7);
    struct Place {
        float scale;
        double offset;
    };
    for (const Place& at : {Place{1e-4f, 0}, Place{1e-2f, 0}, Place{1, 0}, Place{1, 7}, Place{1, 1e3}, Place{1, 1e5}, Place{1e3f, 1e5}, Place{1e6f, 0}, Place{1e6f, 1e5}}) {
        Geometry g;
        generated::addSphere(g, glm::vec3(0), at.scale * glm::vec3(1, 1.5f, 0.8f), 10);
        g = loadedAt(g, glm::dvec3(at.offset, 0.3 * at.offset, -at.offset), moved);
        glm::vec3 low = g.positions[0], high = low;
        for (const glm::vec3& p : g.positions) low = glm::min(low, p), high = glm::max(high, p);
        const glm::vec3 center = 0.5f * (low + high);
        Random random(3);
        std::vector<gpu::Ray> rays(30'000);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            rays[i].origin = center + 0.3f * at.scale * random.uniform() * random.direction();
            const auto& v = g.triangles[i % g.triangles.size()].vertices;
            const glm::vec3 a = g.positions[v[i % 3]], b = g.positions[v[(i + 1) % 3]];
            const glm::vec3 target = i % 3 == 0 ? a : glm::mix(a, b, random.uniform());
            rays[i].direction = i % 2 ? random.direction() : glm::normalize(target - rays[i].origin);
        }
        const Bvh bvh = buildBvh(g);
        const auto hits = Tracer(device(), bvh, bvh.depth).closest(rays);
        const auto where = [&] { return place(double(at.scale), at.offset); };
        for (std::size_t i = 0; i < rays.size(); ++i) {
            lost.add(hits[i].t < 0 ? 1 : 0, where);
            if (hits[i].t < 0) continue;
            const HitErrors errors = errorsOf(g, bvh.order[hits[i].triangle], rays[i], hits[i], nearest(g, rays[i]));
            distance.add(errors.distance, where);
            point.add(errors.point, where);
        }
    }
}

// Rays at points well inside triangles up to 1e5 times longer than wide.
TEST(ExtremeRays, Slivers) {
    const std::string range = " | needles 1e2 to 1e5 times longer than wide, scene 1e-4 to 1e6 units";
    Worst lost("ray | rays that miss a needle they meet" + range, "0", 0), distance("ray | distance to the plane, per largest coordinate" + range, "float64", 1e-6);
    Worst point("ray | point by barycentrics, off the ray, per largest coordinate" + range, "float64", 1e-6);
    for (const float scale : {1e-4f, 1.0f, 1e6f}) {
        Geometry g = generated::slivers(300, 5);
        for (glm::vec3& p : g.positions) p *= scale;
        const Bvh bvh = buildBvh(g);
        Random random(4);
        std::vector<gpu::Ray> rays(20'000);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const Corners p = cornersOf(g, std::uint32_t(i % g.triangles.size()));
            const double u = 0.2 + 0.6 * double(random.uniform()), v = (0.2 + 0.6 * double(random.uniform())) * (1 - u);
            const glm::dvec3 target = p.a + u * (p.b - p.a) + v * (p.c - p.a);
            const glm::dvec3 away(random.direction());
            rays[i].origin = glm::vec3(target + double(scale) * away);
            rays[i].direction = glm::vec3(glm::normalize(target - glm::dvec3(rays[i].origin)));
        }
        const auto hits = Tracer(device(), bvh, bvh.depth).closest(rays);
        std::size_t met = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            double t = std::numeric_limits<double>::infinity(), margin = 0, closest = t;
            for (std::uint32_t k = 0; k < g.triangles.size(); ++k) {
                const auto m = meet(cornersOf(g, k), glm::dvec3(rays[i].origin), glm::dvec3(rays[i].direction));
                if (!m) continue;
                closest = std::min(closest, std::abs(m->margin));
                if (m->margin >= 0 && m->t < t) t = m->t, margin = m->margin;
            }
            if (!std::isfinite(t) || closest < 1e-6 * double(scale)) continue; // an edge of some needle is within rounding of the ray
            ++met;
            const auto where = [&] { return place(double(scale), 0) + " ray " + std::to_string(i) + " margin " + std::to_string(margin / double(scale)); };
            lost.add(hits[i].t < 0 ? 1 : 0, where);
            if (hits[i].t < 0) continue;
            const HitErrors errors = errorsOf(g, bvh.order[hits[i].triangle], rays[i], hits[i], t);
            distance.add(errors.distance, where);
            point.add(errors.point, where);
        }
        EXPECT_GT(met, rays.size() / 4);
    }
}

// Squares that coincide and boxes that share a face: no ray may slip through, whichever is met.
TEST(ExtremeRays, CoplanarAndTouching) {
    const std::string range = " | coincident squares, boxes that share a face, scene 1e-4 to 1e6 units";
    Worst lost("ray | rays that slip through" + range, "0", 0), distance("ray | distance, relative" + range, "float64", 1e-6);
    for (const float scale : {1e-4f, 1.0f, 1e6f}) {
        Geometry g;
        generated::addBox(g, scale * glm::vec3(-1, -1, 0), scale * glm::vec3(1, 1, 1), 3);
        generated::addBox(g, scale * glm::vec3(-1, -1, 1), scale * glm::vec3(1, 1, 2), 4); // another grid on the shared face
        for (const std::uint32_t n : {1u, 1u, 5u})
            generated::addGrid(g, n, n, [&](float u, float v) { return scale * glm::vec3(2 * u - 1, 2 * v - 1, 0); });
        const Bvh bvh = buildBvh(g);
        Random random(6);
        std::vector<gpu::Ray> rays(30'000);
        for (gpu::Ray& r : rays) {
            r.origin = scale * random.inBox({-0.9f, -0.9f, 0.1f}, {0.9f, 0.9f, 0.9f});
            r.direction = random.direction();
        }
        const auto hits = Tracer(device(), bvh, bvh.depth).closest(rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto where = [&] { return place(double(scale), 0); };
            const glm::dvec3 o(rays[i].origin), d(rays[i].direction);
            double t = std::numeric_limits<double>::infinity();
            for (int c = 0; c < 3; ++c) {
                const double low = c == 2 ? 0 : -double(scale), high = double(scale);
                if (d[c] != 0) t = std::min(t, ((d[c] > 0 ? high : low) - o[c]) / d[c]);
            }
            lost.add(hits[i].t < 0 || double(hits[i].t) > 1.001 * t ? 1 : 0, where);
            distance.add(std::abs(double(hits[i].t) - t) / (t + double(scale)), where);
        }
    }
}

} // namespace
} // namespace cmpg::test

// Geometry made by rule for tests and the bench: soups, slivers, a box, a furnished room.
#pragma once

#include "scene/scene.h"

#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <random>

namespace cmpg::generated {

// Only operator() of std::mt19937 is the same everywhere; distributions are not.
class Random {
  public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}
    float uniform() { return float(engine_() >> 8) * 0x1p-24f; }
    float between(float low, float high) { return low + (high - low) * uniform(); }
    glm::vec3 inBox(glm::vec3 low, glm::vec3 high) {
        const float x = uniform(), y = uniform(), z = uniform();
        return low + (high - low) * glm::vec3(x, y, z);
    }
    glm::vec3 direction() {
        const float z = between(-1, 1), phi = between(0, glm::two_pi<float>()), r = std::sqrt(std::max(0.f, 1 - z * z));
        return {r * std::cos(phi), r * std::sin(phi), z};
    }

  private:
    std::mt19937 engine_;
};

inline void addTriangle(Geometry& g, glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    const std::uint32_t n = std::uint32_t(g.positions.size());
    for (const glm::vec3& p : {a, b, c})
        g.positions.push_back(p);
    g.triangles.push_back({{n, n + 1, n + 2}, 0});
}

// A grid of columns x rows quads over the unit square, shared vertices, shaped by `place`.
template <class Place> void addGrid(Geometry& g, std::uint32_t columns, std::uint32_t rows, const Place& place) {
    const std::uint32_t first = std::uint32_t(g.positions.size());
    for (std::uint32_t j = 0; j <= rows; ++j)
        for (std::uint32_t i = 0; i <= columns; ++i)
            g.positions.push_back(place(float(i) / float(columns), float(j) / float(rows)));
    for (std::uint32_t j = 0; j < rows; ++j)
        for (std::uint32_t i = 0; i < columns; ++i) {
            const std::uint32_t a = first + j * (columns + 1) + i, b = a + 1, c = b + columns + 1, d = a + columns + 1;
            const std::array<std::uint32_t, 3> halves[] = {{a, b, c}, {a, c, d}};
            for (const auto& h : halves) // at poles a quad is a triangle
                if (g.positions[h[0]] != g.positions[h[1]] && g.positions[h[1]] != g.positions[h[2]] && g.positions[h[2]] != g.positions[h[0]])
                    g.triangles.push_back({h, 0});
        }
}

inline void addBox(Geometry& g, glm::vec3 low, glm::vec3 high, std::uint32_t cells = 1) {
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side)
            addGrid(g, cells, cells, [&](float u, float v) {
                glm::vec3 t;
                t[axis] = float(side);
                t[(axis + 1) % 3] = side ? u : v;
                t[(axis + 2) % 3] = side ? v : u;
                return low + (high - low) * t;
            });
}

inline void addSphere(Geometry& g, glm::vec3 center, glm::vec3 radii, std::uint32_t rings) {
    addGrid(g, 2 * rings, rings, [&](float u, float v) {
        const float phi = u * glm::two_pi<float>(), theta = v * glm::pi<float>();
        return center + radii * glm::vec3(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
    });
}

// Around the y axis; `radius(v)` for v in [0,1] from bottom to top.
template <class Radius>
void addRevolved(Geometry& g, glm::vec3 foot, float height, std::uint32_t segments, std::uint32_t rows, const Radius& radius) {
    addGrid(g, segments, rows, [&](float u, float v) {
        const float phi = u * glm::two_pi<float>(), r = radius(v);
        return foot + glm::vec3(r * std::cos(phi), height * v, r * std::sin(phi));
    });
}

inline void addCylinder(Geometry& g, glm::vec3 foot, float radius, float height, std::uint32_t segments) {
    addRevolved(g, foot, height, segments, 3, [&](float v) { return v == 0 || v == 1 ? 0.f : radius; });
}

// Triangles of random place, direction and size in the unit cube.
inline Geometry soup(std::uint32_t triangles, float size, std::uint32_t seed) {
    Geometry g;
    Random r(seed);
    for (std::uint32_t i = 0; i < triangles; ++i) {
        const glm::vec3 p = r.inBox(glm::vec3(0), glm::vec3(1));
        const glm::vec3 a = r.direction() * size, b = r.direction() * size;
        addTriangle(g, p, p + a, p + b);
    }
    return g;
}

// Needles: a thousand and more times longer than wide.
inline Geometry slivers(std::uint32_t triangles, std::uint32_t seed) {
    Geometry g;
    Random r(seed);
    for (std::uint32_t i = 0; i < triangles; ++i) {
        const glm::vec3 p = r.inBox(glm::vec3(0), glm::vec3(1)), along = r.direction() * r.between(0.2f, 1.f);
        const glm::vec3 side = r.direction() * std::pow(10.f, r.between(-5, -2.5f));
        addTriangle(g, p, p + along, p + along * r.uniform() + side);
    }
    return g;
}

// A closed box with two smaller ones inside: 36 triangles.
inline Geometry box() {
    Geometry g;
    addBox(g, glm::vec3(-1), glm::vec3(1));
    addBox(g, {-0.6f, -1, -0.5f}, {-0.1f, 0.2f, 0.f});
    addBox(g, {0.15f, -1, 0.f}, {0.6f, -0.4f, 0.5f});
    return g;
}

// A room of 6 x 3 x 5 metres, y up, floor at 0: table, chairs, shelf with books, curtains, rug, plant, lamps, bowls.
// 273 000 triangles for detail 1; their number grows with its square.
inline Geometry room(float detail = 1, std::uint32_t seed = 7) {
    Geometry g;
    Random r(seed);
    const auto n = [&](float count) { return std::uint32_t(std::max(3.f, std::round(count * detail))); };
    addBox(g, {-3, 0, -2.5f}, {3, 3, 2.5f});
    // Rug: a bumpy sheet just above the floor.
    addGrid(g, n(150), n(150), [&](float u, float v) {
        return glm::vec3(-1.8f + 3.6f * u, 0.015f + 0.006f * std::sin(150 * u) * std::sin(130 * v), -1.3f + 2.6f * v);
    });
    // Curtains with folds at two walls.
    for (int side = 0; side < 2; ++side)
        addGrid(g, n(160), n(60), [&](float u, float v) {
            return glm::vec3(-2.8f + 2.1f * u + 3.4f * float(side), 0.05f + 2.7f * v,
                             -2.4f + 0.05f * (1 + std::sin(55 * u + 2 * v)) * (1.2f - v));
        });
    // Table with a cloth, six chairs.
    addBox(g, {-0.9f, 0.72f, -0.5f}, {0.9f, 0.76f, 0.5f}, n(8));
    for (int i = 0; i < 4; ++i)
        addCylinder(g, {i & 1 ? 0.8f : -0.8f, 0, i & 2 ? 0.4f : -0.4f}, 0.03f, 0.72f, n(24));
    for (int i = 0; i < 6; ++i) {
        const float x = -0.6f + 0.6f * float(i % 3), z = i < 3 ? -0.85f : 0.85f;
        addSphere(g, {x, 0.45f, z}, {0.21f, 0.04f, 0.2f}, n(22));
        for (int leg = 0; leg < 4; ++leg)
            addCylinder(g, {x + (leg & 1 ? 0.17f : -0.17f), 0, z + (leg & 2 ? 0.16f : -0.16f)}, 0.015f, 0.45f, n(14));
        for (int bar = 0; bar < 5; ++bar)
            addCylinder(g, {x - 0.16f + 0.08f * float(bar), 0.45f, z + (i < 3 ? -0.18f : 0.18f)}, 0.01f, 0.5f, n(12));
    }
    // Bowls, glasses and fruit on the table.
    for (int i = 0; i < 10; ++i) {
        const glm::vec3 p(-0.75f + 0.16f * float(i), 0.76f, 0.3f * std::sin(3.f * float(i)));
        if (i % 3 == 0)
            addSphere(g, p + glm::vec3(0, 0.05f, 0), glm::vec3(0.05f), n(36));
        else
            addRevolved(g, p, 0.13f, n(48), n(30), [&](float v) { return 0.012f + 0.035f * v * v + 0.02f * std::exp(-60 * v); });
    }
    // Shelf with books.
    for (int level = 0; level < 6; ++level) {
        const float y = 0.1f + 0.42f * float(level);
        addBox(g, {2.6f, y - 0.02f, -2}, {2.98f, y, 2});
        for (float z = -1.95f; z < 1.9f;) {
            const float width = r.between(0.015f, 0.05f), height = r.between(0.2f, 0.36f), depth = r.between(0.2f, 0.3f);
            addBox(g, {2.96f - depth, y, z}, {2.96f, y + height, z + width}, n(3));
            z += width + 0.002f;
        }
    }
    // Sofa of rounded cushions.
    for (int i = 0; i < 6; ++i)
        addSphere(g, {-2.5f, i < 3 ? 0.35f : 0.7f, -0.9f + 0.85f * float(i % 3)}, i < 3 ? glm::vec3(0.45f, 0.18f, 0.42f) : glm::vec3(0.16f, 0.35f, 0.4f),
                  n(44));
    // Plant: leaves as bent strips, seen from all sides.
    addRevolved(g, {2.f, 0, 2.f}, 0.4f, n(48), n(20), [](float v) { return 0.12f + 0.08f * v; });
    for (int i = 0; i < 220; ++i) {
        const float phi = r.between(0, glm::two_pi<float>()), rise = r.between(0.3f, 1.2f), reach = r.between(0.2f, 0.6f), width = r.between(0.01f, 0.03f);
        const glm::vec3 out(std::cos(phi), 0, std::sin(phi)), side(-out.z, 0, out.x);
        addGrid(g, n(20), n(4), [&](float u, float v) {
            return glm::vec3(2, 0.38f, 2) + out * (reach * u) + glm::vec3(0, rise * u * (1.6f - u), 0) +
                   side * ((v - 0.5f) * width * 4 * u * (1.02f - u)) - glm::vec3(0, 0.01f * std::abs(v - 0.5f), 0);
        });
    }
    // Lamps over the table and beside the sofa.
    for (int i = 0; i < 3; ++i) {
        addCylinder(g, {-0.7f + 0.7f * float(i), 2.f, 0}, 0.008f, 1.f, n(12));
        addRevolved(g, {-0.7f + 0.7f * float(i), 1.75f, 0}, 0.25f, n(64), n(40), [](float v) { return 0.22f * std::sqrt(1.001f - v * v * 0.98f); });
        addSphere(g, {-0.7f + 0.7f * float(i), 1.8f, 0}, glm::vec3(0.05f), n(20));
    }
    return g;
}

} // namespace cmpg::generated

// Small scenes for tests.
#pragma once

#include "scene/scene.h"

namespace cmpg::test {

// A scene put together by hand: quads with texture coordinates, constant materials, one orthographic camera of half height 1.
struct SceneBuilder {
    Scene scene;

    std::uint32_t material(const std::string& name, float albedo, float emission) {
        Material m;
        m.name = name;
        const std::array<glm::vec3, kCommonSlots> values{glm::vec3(albedo), {1, 1, 1}, {}, {}, glm::vec3(emission), {0, 0, 1}};
        for (std::uint32_t k = 0; k < kCommonSlots; ++k) {
            Parameter p;
            p.name = name + "." + slotName(SlotKind(k));
            p.kind = SlotKind(k);
            p.channels = p.kind == SlotKind::BaseColor || p.kind == SlotKind::Emission || p.kind == SlotKind::Normal ? 3 : 1;
            p.values.assign(&values[k].x, &values[k].x + p.channels);
            m.parameters[k] = std::uint32_t(scene.parameters.size());
            scene.parameters.push_back(p);
        }
        scene.materials.push_back(m);
        return std::uint32_t(scene.materials.size() - 1);
    }

    // Corner `a`, edges u and v (the front looks along u x v); (0, 0) of the texture is at a.
    void quad(std::uint32_t material, glm::vec3 a, glm::vec3 u, glm::vec3 v) {
        Geometry& g = scene.geometry;
        const std::uint32_t n = std::uint32_t(g.positions.size());
        for (const glm::vec2 c : {glm::vec2(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
            g.positions.push_back(a + c.x * u + c.y * v);
            g.uv0.push_back(c);
        }
        g.triangles.push_back({{n, n + 1, n + 2}, material});
        g.triangles.push_back({{n, n + 2, n + 3}, material});
    }

    // The square [-1,1]^2 at height z, facing up.
    void square(std::uint32_t material, float z) { quad(material, {-1, -1, z}, {2, 0, 0}, {0, 2, 0}); }

    // At height z, looking down.
    void camera(float z) {
        Camera c;
        c.orthographic = true;
        c.toWorld[3] = glm::vec4(0, 0, z, 1);
        scene.cameras = {c};
    }

    // The only point light: a sun of irradiance 2 that shines along `direction`.
    void sun(glm::vec3 direction = {0, 0, -1}) {
        PunctualLight light;
        light.kind = PunctualLight::Kind::Directional;
        light.direction = direction;
        light.intensity = glm::vec3(2);
        scene.lights = {light};
    }
};

} // namespace cmpg::test

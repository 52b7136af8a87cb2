#include "random_scene.h"

#include "support/generated_geometry.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <utility>

namespace cmpg::test {

using generated::Random;

const Parameter& slotOf(const Scene& scene, std::uint32_t material, SlotKind kind) {
    return scene.parameters[scene.materials[material].parameters[std::size_t(kind)]];
}
Parameter& slotOf(Scene& scene, std::uint32_t material, SlotKind kind) {
    return scene.parameters[scene.materials[material].parameters[std::size_t(kind)]];
}

bool emits(const Scene& scene, std::uint32_t material) {
    Parameter p = slotOf(scene, material, SlotKind::Emission);
    p.materialise();
    return std::any_of(p.values.begin(), p.values.end(), [](float v) { return v > 0; });
}

namespace {

class Maker {
  public:
    Maker(std::uint32_t seed, SceneKind kind) : random_(seed * 2 + kind.tame), kind_(kind) {}

    Scene make() {
        colored_ = chance(0.15f);
        secondSet_ = chance(0.2f);
        smoothNormals_ = chance(0.6f);
        const std::uint32_t surfaces = 1 + below(3);
        for (std::uint32_t i = 0; i < surfaces; ++i)
            surface("surface" + std::to_string(i));
        const bool closed = chance(0.4f);
        if (closed)
            room();
        else if (chance(0.7f))
            quad(below(surfaces), {-2, -1, 2}, {4, 0, 0}, {0, 0, -4}, chance(0.5f));
        for (std::uint32_t i = 0, n = 1 + below(3); i < n; ++i)
            object(below(surfaces));
        lights(closed);
        camera(closed);
        scene_.maxDepth = 4;
        return std::move(scene_);
    }

  private:
    std::uint32_t below(std::uint32_t n) { return std::min(n - 1, std::uint32_t(random_.uniform() * float(n))); }
    bool chance(float p) { return random_.uniform() < p; }
    glm::vec3 color(float low, float high) { return random_.inBox(glm::vec3(low), glm::vec3(high)); }

    Parameter parameter(const std::string& name, SlotKind kind, glm::vec3 value) {
        Parameter p;
        p.name = name + "." + slotName(kind);
        p.kind = kind;
        p.channels = kind == SlotKind::BaseColor || kind == SlotKind::Emission || kind == SlotKind::Normal ? 3 : 1;
        p.values.assign(&value.x, &value.x + p.channels);
        return p;
    }

    // Texels around the constant that stands there, within its range.
    void texture(Parameter& p, float spread) {
        p.width = 1 + below(5);
        p.height = 1 + below(5);
        p.wrapU = Wrap(below(3));
        p.wrapV = Wrap(below(3));
        p.nearest = chance(0.2f);
        p.texcoord = secondSet_ && chance(0.4f) ? 1 : 0;
        if (chance(0.3f)) {
            const float angle = random_.between(0, 6), size = random_.between(0.5f, 2);
            p.uvTransform = glm::mat3x2(size * std::cos(angle), -size * std::sin(angle), size * std::sin(angle), size * std::cos(angle), random_.uniform(),
                                        random_.uniform());
        }
        fill(p, spread);
    }

    void fill(Parameter& p, float spread) {
        const std::vector<float> constant = p.values;
        p.textured = true;
        p.values.resize(p.entries());
        for (std::size_t i = 0; i < p.values.size(); ++i) {
            const float c = constant[i % p.channels];
            p.values[i] = p.kind == SlotKind::Emission ? c * random_.between(1 - spread, 1 + spread)
                                                       : std::clamp(c + random_.between(-spread, spread), std::max(p.lowest(), p.kind == SlotKind::Roughness ? least() : p.lowest()), p.highest());
        }
    }
    float least() const { return kind_.tame ? 0.6f : 0.25f; } // roughness: smoother surfaces have heavier tails

    std::uint32_t material(const std::string& name, glm::vec3 emission) {
        Material m;
        m.name = name;
        const float metallic = chance(0.6f) ? 0 : chance(0.3f) ? 1 : random_.uniform();
        const std::array<glm::vec3, kCommonSlots> values{color(0.1f, 0.9f), glm::vec3(random_.between(least(), 1)), glm::vec3(metallic),
                                                           glm::vec3(chance(0.5f) ? 0.f : random_.uniform()), emission, {0, 0, 1}};
        for (std::uint32_t k = 0; k < kCommonSlots; ++k) {
            m.parameters[k] = std::uint32_t(scene_.parameters.size());
            scene_.parameters.push_back(parameter(name, SlotKind(k), values[k]));
        }
        if (kind_.matt)
            for (const SlotKind kind : {SlotKind::Metallic, SlotKind::Specular})
                scene_.parameters[m.parameters[std::size_t(kind)]].values = {0};
        m.ior = chance(0.7f) ? 1.5f : random_.between(1, 2.5f);
        if (chance(0.3f))
            m.specularColor = color(0, 1);
        scene_.materials.push_back(m);
        return std::uint32_t(scene_.materials.size() - 1);
    }

    void surface(const std::string& name) {
        const std::uint32_t at = material(name, glm::vec3(0));
        Material& m = scene_.materials[at];
        if (chance(0.4f))
            texture(slotOf(scene_, at, SlotKind::BaseColor), 0.4f);
        const bool rough = chance(0.25f), metal = !kind_.matt && chance(0.25f);
        if (rough)
            texture(slotOf(scene_, at, SlotKind::Roughness), 0.4f);
        if (metal) {
            Parameter &p = slotOf(scene_, at, SlotKind::Metallic), &like = slotOf(scene_, at, SlotKind::Roughness);
            if (rough) { // two channels of one image
                address(p, like);
                p.width = like.width;
                p.height = like.height;
                fill(p, 0.4f);
            } else {
                texture(p, 0.4f);
            }
        }
        if (!kind_.matt && chance(0.25f))
            texture(slotOf(scene_, at, SlotKind::Specular), 0.4f);
        if (chance(0.2f)) {
            Parameter& p = slotOf(scene_, at, SlotKind::Normal);
            texture(p, 0.3f);
            for (std::size_t i = 0; i < p.values.size(); i += 3) {
                const glm::vec3 n = glm::normalize(glm::vec3(p.values[i], p.values[i + 1], std::max(p.values[i + 2], 0.5f)));
                std::copy_n(&n.x, 3, &p.values[i]);
            }
            m.hasNormalMap = true;
        }
        const Parameter& color = slotOf(scene_, at, SlotKind::BaseColor);
        if (color.textured && chance(0.4f)) {
            AlphaTexture t;
            address(t, color);
            t.width = color.width;
            t.height = color.height;
            for (std::uint32_t i = 0; i < t.width * t.height; ++i)
                t.alpha.push_back(std::uint8_t(chance(0.7f) ? 255 : 0));
            m.alphaMask = true;
            m.alphaTexture = std::uint32_t(scene_.alphaTextures.size());
            scene_.alphaTextures.push_back(t);
        }
    }

    template <class T> static void address(T& texture, const Parameter& like) {
        texture.wrapU = like.wrapU;
        texture.wrapV = like.wrapV;
        texture.nearest = like.nearest;
        texture.texcoord = like.texcoord;
        texture.uvTransform = like.uvTransform;
    }

    std::uint32_t vertex(glm::vec3 position, glm::vec3 normal, glm::vec2 uv) {
        Geometry& g = scene_.geometry;
        g.positions.push_back(position);
        g.uv0.push_back(uv);
        if (smoothNormals_)
            g.normals.push_back(normal);
        if (secondSet_)
            g.uv1.push_back(glm::vec2(uv.y, 1 - uv.x) * 1.5f);
        if (smoothNormals_)
            g.tangents.emplace_back(0);
        if (colored_)
            g.colors.emplace_back(color(0.5f, 1), 1);
        return std::uint32_t(g.positions.size() - 1);
    }

    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t material, bool reversed) {
        if (reversed)
            std::swap(b, c);
        scene_.geometry.triangles.push_back({{a, b, c}, material});
    }

    // Its front looks along u x v, unless it is reversed.
    void quad(std::uint32_t material, glm::vec3 a, glm::vec3 u, glm::vec3 v, bool reversed) {
        std::array<std::uint32_t, 4> n{};
        const std::array<glm::vec2, 4> corners{glm::vec2(0, 0), {1, 0}, {1, 1}, {0, 1}};
        for (std::size_t i = 0; i < 4; ++i)
            n[i] = vertex(a + corners[i].x * u + corners[i].y * v, glm::vec3(0), corners[i]);
        triangle(n[0], n[1], n[2], material, reversed);
        triangle(n[0], n[2], n[3], material, reversed);
    }

    void box(std::uint32_t material, const glm::mat4& place, bool reversed) {
        for (int axis = 0; axis < 3; ++axis)
            for (const float side : {-1.f, 1.f}) {
                glm::vec3 n(0), u(0), v(0);
                n[axis] = side;
                u[(axis + 1) % 3] = 2 * side;
                v[(axis + 2) % 3] = 2;
                quad(material, glm::vec3(place * glm::vec4(n - 0.5f * (u + v), 1)), glm::mat3(place) * u, glm::mat3(place) * v, reversed);
            }
    }

    void sphere(std::uint32_t material, glm::vec3 center, float radius, bool reversed) {
        constexpr std::uint32_t kColumns = 8, kRows = 5;
        const std::uint32_t first = std::uint32_t(scene_.geometry.positions.size());
        for (std::uint32_t j = 0; j <= kRows; ++j)
            for (std::uint32_t i = 0; i <= kColumns; ++i) {
                const float phi = float(i) / kColumns * glm::two_pi<float>(), theta = float(j) / kRows * glm::pi<float>();
                const glm::vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
                vertex(center + radius * n, n, {float(i) / kColumns, float(j) / kRows});
                if (smoothNormals_ && scene_.materials[material].hasNormalMap) // a file without would get others
                    scene_.geometry.tangents.back() = glm::vec4(-std::sin(phi), 0, -std::cos(phi), reversed ? -1 : 1);
            }
        for (std::uint32_t j = 0; j < kRows; ++j)
            for (std::uint32_t i = 0; i < kColumns; ++i) {
                const std::uint32_t a = first + j * (kColumns + 1) + i, b = a + kColumns + 1;
                if (j + 1 < kRows)
                    triangle(a, b, b + 1, material, reversed);
                if (j > 0)
                    triangle(a, b + 1, a + 1, material, reversed);
            }
    }

    void room() {
        const bool reversed = chance(0.5f);
        box(0, glm::scale(glm::mat4(1), glm::vec3(2.5f, 1.5f, 2.5f)), reversed);
    }

    void object(std::uint32_t material) {
        const glm::vec3 center = random_.inBox({-1, -0.7f, -1}, {1, 0.4f, 0.8f});
        const bool reversed = chance(0.5f);
        const glm::mat4 turned = glm::rotate(glm::translate(glm::mat4(1), center), random_.between(0, 6), random_.direction());
        switch (below(3)) {
        case 0:
            box(material, glm::scale(turned, random_.inBox(glm::vec3(0.15f), glm::vec3(0.5f))), reversed);
            break;
        case 1:
            sphere(material, center, random_.between(0.2f, 0.6f), reversed);
            break;
        default:
            quad(material, center, glm::mat3(turned) * glm::vec3(1.2f, 0, 0), glm::mat3(turned) * glm::vec3(0, 1.2f, 0), reversed);
        }
    }

    void lamp() {
        const std::uint32_t at = material("lamp" + std::to_string(scene_.materials.size()), color(2, 12));
        if (chance(0.3f))
            texture(slotOf(scene_, at, SlotKind::Emission), 0.6f);
        const float size = kind_.tame ? random_.between(1, 1.6f) : random_.between(0.2f, 1);
        const glm::vec3 center = random_.inBox({-1, 0.9f, -1}, {1, 1.3f, 1}), along = glm::normalize(-center + random_.direction() * 0.5f);
        const glm::vec3 u = glm::normalize(glm::cross(along, glm::vec3(0.3f, 0.2f, 1))), v = glm::cross(along, u);
        quad(at, center - 0.5f * size * (u + v), size * u, size * v, false);
    }

    void punctual() {
        PunctualLight l;
        l.kind = PunctualLight::Kind(below(3));
        l.position = random_.inBox({-1.5f, 0.3f, -1}, {1.5f, 1.3f, 1.5f});
        l.direction = glm::normalize(-l.position + random_.direction() * 0.3f);
        l.intensity = color(0.5f, 2) * (l.kind == PunctualLight::Kind::Directional ? 1.f : 2.f);
        l.outerCos = random_.between(0.5f, 0.8f);
        l.innerCos = random_.between(0.85f, 1);
        l.range = chance(0.2f) ? random_.between(3, 6) : 0;
        scene_.lights.push_back(l);
    }

    void sky() {
        Parameter p = parameter("environment", SlotKind::Radiance, glm::vec3(0));
        p.channels = 3;
        p.textured = true;
        p.width = 2 + below(7);
        p.height = 2 + below(5);
        p.values.resize(p.entries());
        for (float& v : p.values)
            v = chance(0.2f) ? 0 : random_.between(0.1f, 1);
        scene_.environment = Environment{std::uint32_t(scene_.parameters.size()), random_.between(-3, 3)};
        scene_.parameters.push_back(p);
    }

    void lights(bool closed) {
        const std::uint32_t lamps = below(3), points = kind_.tame ? 0 : below(3);
        for (std::uint32_t i = 0; i < points; ++i)
            punctual();
        const bool dark = lamps + points == 0 || (closed && lamps == 0 && scene_.lights.empty());
        for (std::uint32_t i = 0; i < lamps + (dark && closed ? 1u : 0u); ++i)
            lamp();
        if (!closed && (dark || chance(0.3f)))
            sky(); // the last parameter
    }

    void camera(bool closed) {
        Camera c;
        const glm::vec3 from = closed ? random_.inBox({-1, -0.5f, 1.9f}, {1, 0.8f, 2.2f}) : random_.inBox({-2, -0.5f, 3}, {2, 1.5f, 4});
        c.toWorld = glm::inverse(glm::lookAt(from, random_.inBox(glm::vec3(-0.3f), glm::vec3(0.3f)), glm::vec3(0.1f, 1, 0)));
        c.yfov = closed ? 1.2f : 0.8f;
        if (!closed && chance(0.1f)) {
            c.orthographic = true;
            c.ymag = 1.5f;
        }
        scene_.cameras = {c};
    }

    Random random_;
    SceneKind kind_;
    Scene scene_;
    bool colored_ = false, secondSet_ = false, smoothNormals_ = false;
};

} // namespace

Scene randomScene(std::uint32_t seed, SceneKind kind) { return Maker(seed, kind).make(); }

} // namespace cmpg::test

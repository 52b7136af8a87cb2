#include "relations.h"

#include "random_scene.h"
#include "scene_file.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <numeric>
#include <utility>

namespace cmpg::test {
namespace {

using generated::Random;
using Terms = std::vector<Term>;

constexpr double kRounding = 2e-5;

Term same(const Scene& scene) { return {scene, sameParameters(scene)}; }
bool always(const Scene&) { return true; }
bool hasPunctual(const Scene& s) { return !s.lights.empty(); }
std::uint32_t below(Random& r, std::size_t n) { return std::uint32_t(std::min(n - 1, std::size_t(r.uniform() * float(n)))); }

template <class T> void shuffle(std::vector<T>& list, Random& r) {
    for (std::size_t i = list.size(); i > 1; --i)
        std::swap(list[i - 1], list[below(r, i)]);
}
std::vector<std::uint32_t> order(std::size_t n, Random& r) {
    std::vector<std::uint32_t> o(n);
    std::iota(o.begin(), o.end(), 0u);
    shuffle(o, r);
    return o;
}

// Corners of what does not emit run the other way. Not where a normal map is: its frame turns with the corners, as MikkTSpace's does.
Terms reversedCorners(const Scene& scene, Random&) {
    Term t = same(scene);
    for (Triangle& triangle : t.scene.geometry.triangles)
        if (!emits(scene, triangle.material) && !scene.materials[triangle.material].hasNormalMap)
            std::swap(triangle.vertices[1], triangle.vertices[2]);
    return {t};
}

// Corners keep their sense, and begin with another one.
Terms turnedCorners(const Scene& scene, Random& r) {
    Term t = same(scene);
    for (Triangle& triangle : t.scene.geometry.triangles)
        std::rotate(triangle.vertices.begin(), triangle.vertices.begin() + below(r, 3), triangle.vertices.end());
    return {t};
}

void transform(Scene& scene, const glm::mat4& m, float scale) {
    const glm::mat3 turn = glm::mat3(m) / scale;
    Geometry& g = scene.geometry;
    for (glm::vec3& p : g.positions)
        p = glm::vec3(m * glm::vec4(p, 1));
    for (glm::vec3& n : g.normals)
        n = turn * n;
    for (glm::vec4& t : g.tangents)
        t = glm::vec4(turn * glm::vec3(t), t.w);
    for (Camera& c : scene.cameras) {
        c.toWorld = glm::mat4(glm::mat4(turn) * glm::mat4(glm::mat3(c.toWorld)));
        c.toWorld[3] = glm::vec4(0, 0, 0, 1);
        c.ymag *= scale;
    }
    for (PunctualLight& l : scene.lights) {
        l.position = glm::vec3(m * glm::vec4(l.position, 1));
        l.direction = turn * l.direction;
        l.range *= scale;
        if (l.kind != PunctualLight::Kind::Directional)
            l.intensity *= scale * scale;
    }
}

// The camera's place apart, which its frame would lose.
void transformAll(Scene& scene, const glm::mat4& m, float scale) {
    std::vector<glm::vec4> places;
    for (const Camera& c : scene.cameras)
        places.push_back(m * c.toWorld[3]);
    transform(scene, m, scale);
    for (std::size_t i = 0; i < places.size(); ++i)
        scene.cameras[i].toWorld[3] = places[i];
}

Terms moved(const Scene& scene, Random& r) {
    Term t = same(scene);
    const float angle = r.between(-3, 3);
    const glm::vec3 axis = scene.environment ? glm::vec3(0, 1, 0) : r.direction(); // a map turns about y alone
    transformAll(t.scene, glm::rotate(glm::translate(glm::mat4(1), r.inBox(glm::vec3(-1), glm::vec3(1))), angle, axis), 1);
    if (t.scene.environment)
        t.scene.environment->rotation += angle;
    return {t};
}

// Powers grow with the area: radiance stays.
Terms scaled(const Scene& scene, Random& r) {
    Term t = same(scene);
    const float scale = std::exp2(std::round(r.between(-6, 6)) * (r.uniform() < 0.5f ? 1.f : 0.73f));
    transformAll(t.scene, glm::scale(glm::mat4(1), glm::vec3(scale)), scale);
    return {t};
}

Terms triangleOrder(const Scene& scene, Random& r) {
    Term t = same(scene);
    shuffle(t.scene.geometry.triangles, r);
    return {t};
}

Terms materialOrder(const Scene& scene, Random& r) {
    Term t = same(scene);
    const std::vector<std::uint32_t> materials = order(scene.materials.size(), r), parameters = order(scene.parameters.size(), r);
    for (std::size_t i = 0; i < materials.size(); ++i)
        t.scene.materials[materials[i]] = scene.materials[i];
    for (std::size_t i = 0; i < parameters.size(); ++i) {
        t.scene.parameters[parameters[i]] = scene.parameters[i];
        t.sources[parameters[i]].parameter = std::uint32_t(i);
    }
    for (Material& m : t.scene.materials)
        for (std::uint32_t& p : m.parameters)
            p = p == kNoParameter ? p : parameters[p];
    for (Triangle& triangle : t.scene.geometry.triangles)
        triangle.material = materials[triangle.material];
    if (t.scene.environment)
        t.scene.environment->parameter = parameters[t.scene.environment->parameter];
    return {t};
}

Terms lightOrder(const Scene& scene, Random& r) {
    Term t = same(scene);
    shuffle(t.scene.lights, r);
    return {t};
}

template <class T> T middle(const T& a, const T& b) { return (a + b) * 0.5f; }

// Every triangle that is chosen becomes four.
void quarter(Scene& scene, bool lampsOnly, float share, Random& r) {
    Geometry& g = scene.geometry;
    const auto between = [&](std::uint32_t a, std::uint32_t b) {
        const auto add = [&](auto& list) {
            if (!list.empty())
                list.push_back(middle(list[a], list[b]));
        };
        add(g.positions);
        add(g.normals); // not of unit length: what is interpolated is the same
        add(g.uv0);
        add(g.uv1);
        add(g.tangents);
        add(g.colors);
        return std::uint32_t(g.positions.size() - 1);
    };
    std::vector<Triangle> all;
    for (const Triangle& t : g.triangles) {
        if ((lampsOnly && !emits(scene, t.material)) || r.uniform() >= share) {
            all.push_back(t);
            continue;
        }
        const auto [a, b, c] = t.vertices;
        const std::uint32_t ab = between(a, b), bc = between(b, c), ca = between(c, a);
        for (const std::array<std::uint32_t, 3>& v : {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
            all.push_back({v, t.material});
    }
    g.triangles = all;
}

Terms quarteredTriangles(const Scene& scene, Random& r) {
    Term t = same(scene);
    quarter(t.scene, false, 0.5f, r);
    return {t};
}

bool hasLamps(const Scene& s) {
    return std::any_of(s.geometry.triangles.begin(), s.geometry.triangles.end(), [&](const Triangle& t) { return emits(s, t.material); });
}

Terms lampInPieces(const Scene& scene, Random& r) {
    Term t = same(scene);
    for (int i = 0; i < 2; ++i)
        quarter(t.scene, true, 0.7f, r);
    return {t};
}

// Half the triangles get a copy of their material.
Terms duplicatedMaterial(const Scene& scene, Random& r) {
    Term t = same(scene);
    const std::uint32_t at = below(r, scene.materials.size());
    Material copy = scene.materials[at];
    for (std::uint32_t& p : copy.parameters) {
        if (p == kNoParameter)
            continue;
        t.scene.parameters.push_back(scene.parameters[p]);
        t.sources.push_back({p});
        p = std::uint32_t(t.scene.parameters.size() - 1);
    }
    t.scene.materials.push_back(copy);
    for (Triangle& triangle : t.scene.geometry.triangles)
        if (triangle.material == at && r.uniform() < 0.5f)
            triangle.material = std::uint32_t(t.scene.materials.size() - 1);
    return {t};
}

// Every constant but the normal becomes a texture of one colour.
Terms constantsAsTextures(const Scene& scene, std::uint32_t width, std::uint32_t height) {
    Term t = same(scene);
    for (std::uint32_t i = 0; i < scene.parameters.size(); ++i) {
        Parameter& p = t.scene.parameters[i];
        if (p.textured || p.kind == SlotKind::Normal)
            continue;
        const std::vector<float> constant = p.values;
        p.textured = true;
        p.width = width;
        p.height = height;
        p.values.clear();
        for (std::size_t e = 0; e < p.entries(); ++e) {
            p.values.push_back(constant[e % p.channels]);
            t.sources[i].index.push_back(std::uint32_t(e % p.channels));
        }
    }
    return {t};
}
Terms constantsAsTexels(const Scene& scene, Random&) { return constantsAsTextures(scene, 1, 1); }
Terms constantsAsMaps(const Scene& scene, Random&) { return constantsAsTextures(scene, 9, 7); }

// Every triangle has its own corners, as in a file without indices.
Terms withoutIndices(const Scene& scene, Random&) {
    Term t = same(scene);
    const Geometry& from = scene.geometry;
    Geometry g;
    for (Triangle triangle : from.triangles) {
        for (std::uint32_t& v : triangle.vertices) {
            const auto add = [&](const auto& list, auto& own) {
                if (!list.empty())
                    own.push_back(list[v]);
            };
            add(from.normals, g.normals);
            add(from.uv0, g.uv0);
            add(from.uv1, g.uv1);
            add(from.tangents, g.tangents);
            add(from.colors, g.colors);
            add(from.positions, g.positions);
            v = std::uint32_t(g.positions.size() - 1);
        }
        g.triangles.push_back(triangle);
    }
    t.scene.geometry = g;
    return {t};
}

// The triangles' own normals, written out where there are none.
Terms flatNormals(const Scene& scene, Random& r) {
    Term t = withoutIndices(scene, r)[0];
    Geometry& g = t.scene.geometry;
    g.normals.resize(g.positions.size(), glm::vec3(0));
    for (const Triangle& triangle : g.triangles) {
        const auto [a, b, c] = triangle.vertices;
        if (g.normals[a] == glm::vec3(0) && g.normals[b] == glm::vec3(0) && g.normals[c] == glm::vec3(0))
            g.normals[a] = g.normals[b] = g.normals[c] = glm::vec3(glm::normalize(
                glm::cross(glm::dvec3(g.positions[b]) - glm::dvec3(g.positions[a]), glm::dvec3(g.positions[c]) - glm::dvec3(g.positions[a]))));
    }
    return {t};
}

Terms whiteColors(const Scene& scene, Random&) {
    Term t = same(scene);
    t.scene.geometry.colors.assign(t.scene.geometry.positions.size(), glm::vec4(1));
    return {t};
}
bool hasNoColors(const Scene& s) { return s.geometry.colors.empty(); }

Terms otherCoordinates(const Scene& scene, Random&) {
    Term t = same(scene);
    Geometry& g = t.scene.geometry;
    g.uv1.resize(g.positions.size(), glm::vec2(0));
    std::swap(g.uv0, g.uv1);
    for (Parameter& p : t.scene.parameters)
        p.texcoord = 1 - p.texcoord;
    for (AlphaTexture& a : t.scene.alphaTextures)
        a.texcoord = 1 - a.texcoord;
    return {t};
}
bool hasCoordinates(const Scene& s) { return !s.geometry.uv0.empty(); }

// Coordinates are halved, and doubled again by the textures' transforms.
Terms transformedCoordinates(const Scene& scene, Random&) {
    Term t = same(scene);
    for (glm::vec2& uv : t.scene.geometry.uv0)
        uv *= 0.5f;
    const auto twice = [](auto& texture) {
        if (texture.texcoord == 0) {
            texture.uvTransform[0] *= 2.f;
            texture.uvTransform[1] *= 2.f;
        }
    };
    for (Parameter& p : t.scene.parameters)
        twice(p);
    for (AlphaTexture& a : t.scene.alphaTextures)
        twice(a);
    return {t};
}

// Where there was a lamp, there are two that share its power.
Terms sharedPower(const Scene& scene, Random& r) {
    Term t = same(scene);
    for (const PunctualLight& l : scene.lights) {
        const float share = r.between(0.1f, 0.9f);
        t.scene.lights.push_back(l);
        t.scene.lights.back().intensity *= 1 - share;
        t.scene.lights[std::size_t(&l - scene.lights.data())].intensity *= share;
    }
    return {t};
}

// A map by columns, and its rotation back.
Terms rolledMap(const Scene& scene, Random& r) {
    Term t = same(scene);
    const std::uint32_t at = scene.environment->parameter;
    Parameter& p = t.scene.parameters[at];
    const std::uint32_t columns = 1 + below(r, p.width);
    t.sources[at].index.resize(p.entries());
    for (std::uint32_t y = 0; y < p.height; ++y)
        for (std::uint32_t x = 0; x < p.width; ++x)
            for (std::uint32_t c = 0; c < 3; ++c) {
                const std::uint32_t to = (y * p.width + (x + columns) % p.width) * 3 + c, from = (y * p.width + x) * 3 + c;
                t.sources[at].index[to] = from;
                p.values[to] = scene.parameters[at].values[from];
            }
    // u = atan2(x, -z) / 2 pi grows against the rotation about +y.
    t.scene.environment->rotation += glm::two_pi<float>() * float(columns) / float(p.width);
    return {t};
}
bool hasMap(const Scene& s) { return s.environment.has_value(); }

void multiplyLights(Term& t, std::uint32_t parameter, float factor) {
    for (float& v : t.scene.parameters[parameter].values)
        v *= factor;
    t.sources[parameter].scale = factor;
}

std::vector<std::uint32_t> shining(const Scene& scene) {
    std::vector<std::uint32_t> found;
    for (std::uint32_t m = 0; m < scene.materials.size(); ++m)
        if (emits(scene, m))
            found.push_back(scene.materials[m].parameters[std::size_t(SlotKind::Emission)]);
    if (scene.environment)
        found.push_back(scene.environment->parameter);
    return found;
}

Terms brighter(const Scene& scene, Random& r) {
    Term t = same(scene);
    const float factor = r.between(1.5f, 20);
    t.weight = 1 / double(factor);
    for (const std::uint32_t p : shining(scene))
        multiplyLights(t, p, factor);
    for (PunctualLight& l : t.scene.lights)
        l.intensity *= factor;
    return {t};
}

// Some of the lights, and the others.
Terms inTwo(const Scene& scene, Random& r) {
    Terms terms{same(scene), same(scene)};
    for (const std::uint32_t p : shining(scene)) {
        Term& dark = terms[below(r, 2)];
        std::fill(dark.scene.parameters[p].values.begin(), dark.scene.parameters[p].values.end(), 0.f);
        dark.sources[p].parameter = ~0u;
    }
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        terms[below(r, 2)].scene.lights[i].intensity = glm::vec3(0);
    return terms;
}
bool hasSeveral(const Scene& s) { return shining(s).size() + s.lights.size() > 1; }

template <FileStyle style> Terms fromFile(const Scene& scene, Random& r) {
    Term t{throughFile(scene, style, r), sameParameters(scene)};
    for (std::size_t p = 0; p < scene.parameters.size(); ++p) {
        Parameter& loaded = t.scene.parameters[p];
        loaded.materialise();
        if (loaded.entries() != scene.parameters[p].entries()) // the constant beside a texture that shares its image
            for (std::size_t i = 0; i < loaded.entries(); ++i)
                t.sources[p].index.push_back(std::uint32_t(i % loaded.channels));
    }
    return {t};
}

Terms unlike(const Scene& scene, const Setup& setup) {
    Term t = same(scene);
    t.setup = setup;
    return {t};
}

// A map that is dark but for a small patch, instead of light from one direction.
Terms patchForSun(const Scene& scene, Random&) {
    Term t = same(scene);
    const std::size_t sun = std::size_t(std::find_if(scene.lights.begin(), scene.lights.end(), [](const PunctualLight& l) { return l.kind == PunctualLight::Kind::Directional; }) -
                                        scene.lights.begin());
    const PunctualLight l = scene.lights[sun];
    t.scene.lights.erase(t.scene.lights.begin() + std::ptrdiff_t(sun));
    Parameter p;
    p.name = "environment.radiance";
    p.kind = SlotKind::Radiance;
    p.textured = true;
    p.width = 512;
    p.height = 257;
    p.values.assign(p.entries(), 0);
    const glm::vec3 to = -l.direction;
    const float phi = std::atan2(to.x, -to.z), theta = std::acos(glm::clamp(to.y, -1.f, 1.f));
    const float u = phi < 0 ? phi / glm::two_pi<float>() + 1 : phi / glm::two_pi<float>();
    // The texel nearest to the direction, turned about y to its very azimuth; its bilinear tent covers the solid angle of a texel.
    const std::uint32_t column = std::uint32_t(u * float(p.width)) % p.width, row = std::uint32_t(std::lround(theta / glm::pi<float>() * float(p.height - 1)));
    const float step = glm::pi<float>() / float(p.height - 1), angle = glm::two_pi<float>() / float(p.width) * step * std::sin(float(row) * step);
    for (int c = 0; c < 3; ++c)
        p.values[(std::size_t(row) * p.width + column) * 3 + std::size_t(c)] = l.intensity[c] / angle;
    t.scene.environment = Environment{std::uint32_t(t.scene.parameters.size()), glm::two_pi<float>() * ((float(column) + 0.5f) / float(p.width) - u)};
    t.scene.parameters.push_back(p);
    t.sources.push_back({});
    return {t};
}
// Near the poles a texel is not small in every direction.
bool hasSun(const Scene& s) {
    return !s.environment && std::any_of(s.lights.begin(), s.lights.end(), [](const PunctualLight& l) {
        return l.kind == PunctualLight::Kind::Directional && std::abs(l.direction.y) < 0.95f;
    });
}

} // namespace

const std::vector<Relation>& relations() {
    using enum Agreement;
    static const std::vector<Relation> all{
        {"corners reversed of what does not emit", Coupled, kRounding, false, always, reversedCorners},
        {"corners turned", Coupled, kRounding, false, always, turnedCorners},
        {"everything moved", Expected, kRounding, false, always, moved},
        {"everything scaled", Coupled, kRounding, false, always, scaled},
        {"order of triangles", Coupled, kRounding, false, always, triangleOrder},
        {"order of materials", Bits, 0, false, always, materialOrder},
        {"order of punctual lights", Expected, kRounding, false, [](const Scene& s) { return s.lights.size() > 1; }, lightOrder},
        {"triangles in four", Coupled, kRounding, false, always, quarteredTriangles},
        {"lamps in pieces", Expected, kRounding, false, hasLamps, lampInPieces},
        {"material duplicated", Bits, 0, false, always, duplicatedMaterial},
        {"constants as textures of one texel", Bits, 0, false, always, constantsAsTexels},
        {"constants as large textures", Coupled, kRounding, false, hasCoordinates, constantsAsMaps},
        {"corners not shared", Bits, 0, false, always, withoutIndices},
        {"flat normals written out", Coupled, kRounding, false, always, flatNormals},
        {"white vertex colours", Bits, 0, false, hasNoColors, whiteColors},
        {"the other texture coordinates", Bits, 0, false, hasCoordinates, otherCoordinates},
        {"coordinates halved", Coupled, kRounding, false, hasCoordinates, transformedCoordinates},
        {"two lamps that share the power of one", Expected, kRounding, false, hasPunctual, sharedPower},
        {"map rolled", Coupled, kRounding, false, hasMap, rolledMap},
        {"lights brighter", Coupled, kRounding, false, always, brighter},
        {"lights one after the other", Expected, kRounding, false, hasSeveral, inTwo},
        {"patch of a map for a far lamp", Expected, 0.01, false, hasSun, patchForSun},
        {"through a plain file", Coupled, kRounding, false, fitsFile, fromFile<FileStyle::Plain>},
        {"through a file of mirrored nodes", Coupled, kRounding, false, fitsFile, fromFile<FileStyle::Mirrored>},
        {"through a file of nested nodes without indices", Coupled, kRounding, false, fitsFile, fromFile<FileStyle::Nested>},
        {"through a file of instances", Coupled, kRounding, false, fitsFile, fromFile<FileStyle::Instanced>},
        {"light sampling off", Expected, kRounding, true, [](const Scene& s) { return s.lights.empty(); },
         [](const Scene& s, Random&) { return unlike(s, {.lightSampling = false}); }},
        {"independent samples", Expected, kRounding, false, always, [](const Scene& s, Random&) { return unlike(s, {.sampler = Sampler::Independent}); }},
        {"guided by light", Expected, kRounding, false, always,
         [](const Scene& s, Random& r) { return unlike(s, {.guided = Sampling::Primal, .guideShare = r.between(0.1f, 0.95f)}); }},
        {"guided by derivatives", Expected, kRounding, false, always,
         [](const Scene& s, Random& r) { return unlike(s, {.guided = Sampling::Differential, .guideShare = r.between(0.1f, 0.95f)}); }},
        {"guided by both alike", Expected, kRounding, false, always,
         [](const Scene& s, Random& r) { return unlike(s, {.guided = Sampling::Uniform, .guideShare = r.between(0.1f, 0.95f)}); }},
        {"guided by the conditional mixture", Expected, kRounding, false, always,
         [](const Scene& s, Random& r) { return unlike(s, {.guided = Sampling::Conditional, .guideShare = r.between(0.1f, 0.95f)}); }},
        {"roulette", Expected, kRounding, false, always,
         [](const Scene& s, Random&) { return unlike(s, {.guided = Sampling::Conditional, .roulette = true}); }},
    };
    return all;
}

} // namespace cmpg::test

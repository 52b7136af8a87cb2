#include "scene_file.h"

#include "scene/gltf_writer.h"
#include "scene/image.h"

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <map>
#include <numeric>

namespace cmpg::test {
namespace {

using generated::Random;

const Parameter& slot(const Scene& scene, const Material& m, SlotKind kind) { return scene.parameters[m.parameters[std::size_t(kind)]]; }

template <class A, class B> bool sameAddress(const A& a, const B& b) {
    return a.width == b.width && a.height == b.height && a.wrapU == b.wrapU && a.wrapV == b.wrapV && a.nearest == b.nearest && a.texcoord == b.texcoord &&
           a.uvTransform == b.uvTransform;
}

class FileMaker {
  public:
    FileMaker(const Scene& scene, FileStyle style, Random& random) : scene_(scene), style_(style), random_(random) {
        file_.json["nodes"] = Json::array();
        file_.json["materials"] = Json::array();
    }

    Scene make() {
        for (const Material& m : scene_.materials)
            material(m);
        if (style_ == FileStyle::Instanced)
            instances();
        else
            meshes();
        lights();
        camera();
        Json& nodes = roots_;
        if (style_ == FileStyle::Nested)
            std::reverse(nodes.begin(), nodes.end());
        file_.json["scenes"] = {{{"nodes", nodes}, {"extras", {{"maxDepth", scene_.maxDepth}}}}};
        if (scene_.environment) {
            const Parameter& p = scene_.parameters[scene_.environment->parameter];
            Image image(int(p.width), int(p.height), 3);
            image.values = p.values;
            writeExr(folder_ / "sky.exr", image);
            file_.json["scenes"][0]["extras"]["environment"] = {{"uri", "sky.exr"}, {"rotation", scene_.environment->rotation}};
        }
        return loadScene(file_.write(folder_));
    }

  private:
    // One node, or a chain of them that comes to the same.
    void node(Json content, const glm::dmat4& toWorld) {
        Json& nodes = file_.json["nodes"];
        const auto matrix = [](const glm::dmat4& m) {
            std::vector<double> v;
            for (int i = 0; i < 16; ++i)
                v.push_back(m[i / 4][i % 4]);
            return v;
        };
        glm::dmat4 above(1);
        if (style_ == FileStyle::Nested)
            above = glm::scale(glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(random_.inBox(glm::vec3(-2), glm::vec3(2)))), double(random_.between(-3, 3)),
                                           glm::dvec3(random_.direction())),
                               glm::dvec3(random_.between(0.4f, 2)));
        content["matrix"] = matrix(glm::inverse(above) * toWorld);
        nodes.push_back(content);
        if (style_ == FileStyle::Nested)
            nodes.push_back({{"matrix", matrix(above)}, {"children", {nodes.size() - 1}}});
        roots_.push_back(nodes.size() - 1);
    }

    std::size_t texture(std::uint32_t width, std::uint32_t height, const std::array<std::vector<float>, 4>& channels, const Parameter& how) {
        std::vector<std::pair<std::string, Image>> planes;
        for (std::size_t c = 0; c < 4; ++c) {
            Image plane(int(width), int(height), 1);
            plane.values = channels[c];
            planes.emplace_back(std::string(1, "RGBA"[c]), plane);
        }
        const std::string name = "image" + std::to_string(images_++) + ".exr";
        writeExrLayers(folder_ / name, planes);
        const auto wrap = [](Wrap w) { return w == Wrap::Repeat ? 10497 : w == Wrap::Clamp ? 33071 : 33648; };
        file_.json["images"].push_back({{"uri", name}});
        file_.json["samplers"].push_back({{"wrapS", wrap(how.wrapU)}, {"wrapT", wrap(how.wrapV)}, {"magFilter", how.nearest ? 9728 : 9729}});
        file_.json["textures"].push_back({{"source", images_ - 1}, {"sampler", images_ - 1}});
        return images_ - 1;
    }
    static Json use(std::size_t texture, const Parameter& how) {
        const glm::mat3x2& m = how.uvTransform;
        const double size = std::hypot(m[0].x, m[0].y), angle = std::atan2(-m[0].y, m[0].x);
        return {{"index", texture},
                {"texCoord", how.texcoord},
                {"extensions", {{"KHR_texture_transform", {{"offset", {m[2].x, m[2].y}}, {"rotation", angle}, {"scale", {size, size}}}}}}};
    }
    static std::vector<float> channel(const Parameter& p, std::uint32_t c, std::size_t texels) {
        std::vector<float> values(texels);
        for (std::size_t i = 0; i < texels; ++i)
            values[i] = p.textured ? p.values[i * p.channels + c] : p.values[c];
        return values;
    }

    void material(const Material& m) {
        Json pbr, j = {{"name", m.name}};
        const Parameter &color = slot(scene_, m, SlotKind::BaseColor), &rough = slot(scene_, m, SlotKind::Roughness), &metal = slot(scene_, m, SlotKind::Metallic);
        const Parameter &specular = slot(scene_, m, SlotKind::Specular), &emission = slot(scene_, m, SlotKind::Emission), &normal = slot(scene_, m, SlotKind::Normal);
        const auto ones = [](const Parameter& p) { return std::vector<float>(p.width * p.height, 1.f); };
        const auto rgb = [&](const Parameter& p, const std::vector<float>& alpha) {
            const std::size_t n = p.width * p.height;
            return use(texture(p.width, p.height, {channel(p, 0, n), channel(p, 1, n), channel(p, 2, n), alpha}, p), p);
        };
        if (color.textured) {
            std::vector<float> alpha = ones(color);
            for (std::size_t i = 0; m.alphaMask && m.alphaTexture != ~0u && i < alpha.size(); ++i)
                alpha[i] = float(scene_.alphaTextures[m.alphaTexture].alpha[i]) / 255.f;
            pbr["baseColorTexture"] = rgb(color, alpha);
        } else {
            pbr["baseColorFactor"] = {color.values[0], color.values[1], color.values[2], 1};
        }
        if (m.alphaMask) {
            if (color.textured)
                pbr["baseColorFactor"] = {1, 1, 1, m.alphaFactor};
            else
                pbr["baseColorFactor"][3] = m.alphaFactor;
            j["alphaMode"] = "MASK";
            j["alphaCutoff"] = m.alphaCutoff;
        }
        if (rough.textured || metal.textured) {
            const Parameter& how = rough.textured ? rough : metal;
            const std::size_t n = how.width * how.height;
            pbr["metallicRoughnessTexture"] = use(texture(how.width, how.height, {ones(how), channel(rough, 0, n), channel(metal, 0, n), ones(how)}, how), how);
        } else {
            pbr["roughnessFactor"] = rough.values[0];
            pbr["metallicFactor"] = metal.values[0];
        }
        Json s = {{"specularColorFactor", {m.specularColor.x, m.specularColor.y, m.specularColor.z}}};
        if (specular.textured)
            s["specularTexture"] = use(texture(specular.width, specular.height, {ones(specular), ones(specular), ones(specular), channel(specular, 0, ones(specular).size())}, specular), specular);
        else
            s["specularFactor"] = specular.values[0];
        j["extensions"] = {{"KHR_materials_specular", s}, {"KHR_materials_ior", {{"ior", m.ior}}}};
        const float strength = std::max(1.f, *std::max_element(emission.values.begin(), emission.values.end()));
        j["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", strength}};
        if (emission.textured) {
            Parameter scaled = emission;
            for (float& v : scaled.values)
                v /= strength;
            j["emissiveTexture"] = rgb(scaled, ones(emission));
            j["emissiveFactor"] = {1, 1, 1};
        } else {
            j["emissiveFactor"] = {emission.values[0] / strength, emission.values[1] / strength, emission.values[2] / strength};
        }
        if (m.hasNormalMap) {
            Parameter encoded = normal;
            for (float& v : encoded.values)
                v = 0.5f * (v + 1);
            j["normalTexture"] = rgb(encoded, ones(normal));
        }
        j["pbrMetallicRoughness"] = pbr;
        file_.json["materials"].push_back(j);
    }

    // Triangles with equal optional attributes make a mesh. `toWorld`: of the node it goes to.
    std::size_t mesh(const std::vector<Triangle>& triangles, const glm::dmat4& toWorld, bool indexed) {
        const Geometry& g = scene_.geometry;
        const glm::dmat4 toLocal = glm::inverse(toWorld);
        const glm::dmat3 linear(toWorld);
        const double sign = glm::determinant(linear) < 0 ? -1 : 1;
        std::vector<std::uint32_t> vertices;
        std::vector<std::uint16_t> indices;
        std::map<std::uint32_t, std::uint16_t> known;
        for (const Triangle& t : triangles)
            for (const int k : {0, sign < 0 ? 2 : 1, sign < 0 ? 1 : 2}) { // a mirrored triangle, seen in its own space, runs the other way
                const std::uint32_t v = t.vertices[std::size_t(k)];
                if (!indexed || !known.contains(v)) {
                    known[v] = std::uint16_t(vertices.size());
                    vertices.push_back(v);
                }
                indices.push_back(known[v]);
            }
        Json attributes;
        const auto floats = [&](const char* name, std::size_t components, const auto& value) {
            std::vector<float> values;
            for (const std::uint32_t v : vertices) {
                const auto x = value(v);
                for (std::size_t c = 0; c < components; ++c)
                    values.push_back(float(x[int(c)]));
            }
            attributes[name] = file_.floats(values, components);
        };
        floats("POSITION", 3, [&](std::uint32_t v) { return glm::dvec3(toLocal * glm::dvec4(glm::dvec3(g.positions[v]), 1)); });
        if (!g.normals.empty() && g.normals[vertices[0]] != glm::vec3(0))
            floats("NORMAL", 3, [&](std::uint32_t v) { return glm::normalize(glm::transpose(linear) * glm::dvec3(g.normals[v])); });
        if (!g.tangents.empty() && glm::vec3(g.tangents[vertices[0]]) != glm::vec3(0))
            floats("TANGENT", 4, [&](std::uint32_t v) {
                return glm::dvec4(glm::normalize(glm::dmat3(toLocal) * glm::dvec3(g.tangents[v])), sign * double(g.tangents[v].w));
            });
        if (!g.uv0.empty())
            floats("TEXCOORD_0", 2, [&](std::uint32_t v) { return glm::dvec2(g.uv0[v]); });
        if (!g.uv1.empty())
            floats("TEXCOORD_1", 2, [&](std::uint32_t v) { return glm::dvec2(g.uv1[v]); });
        if (!g.colors.empty())
            floats("COLOR_0", 4, [&](std::uint32_t v) { return glm::dvec4(g.colors[v]); });
        Json primitive = {{"attributes", attributes}, {"material", triangles[0].material}};
        if (indexed)
            primitive["indices"] = file_.indices(indices);
        file_.json["meshes"].push_back({{"primitives", {primitive}}});
        return file_.json["meshes"].size() - 1;
    }

    void meshes() {
        const Geometry& g = scene_.geometry;
        const auto key = [&](const Triangle& t) {
            const std::uint32_t v = t.vertices[0];
            return std::array<std::uint32_t, 3>{t.material, !g.normals.empty() && g.normals[v] != glm::vec3(0), !g.tangents.empty() && glm::vec3(g.tangents[v]) != glm::vec3(0)};
        };
        std::map<std::array<std::uint32_t, 3>, std::vector<Triangle>> groups;
        for (const Triangle& t : g.triangles)
            groups[key(t)].push_back(t);
        for (const auto& [which, triangles] : groups) {
            glm::dmat4 toWorld(1);
            if (style_ != FileStyle::Plain)
                toWorld = glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(random_.inBox(glm::vec3(-1), glm::vec3(1)))), double(random_.between(-3, 3)),
                                      glm::dvec3(random_.direction()));
            if (style_ == FileStyle::Mirrored)
                toWorld = glm::scale(toWorld, glm::dvec3(-1, 1, 1));
            if (style_ == FileStyle::Nested)
                toWorld = glm::scale(toWorld, glm::dvec3(random_.between(0.5f, 2), random_.between(0.5f, 2), random_.between(0.5f, 2)));
            node({{"mesh", mesh(triangles, toWorld, style_ != FileStyle::Nested)}}, toWorld);
        }
    }

    // A triangle is the image of any other under the map that takes corners to corners and leaves what is in front in front.
    void instances() {
        const Geometry& g = scene_.geometry;
        std::map<std::vector<float>, std::size_t> known; // by material and attributes
        for (const Triangle& t : g.triangles) {
            const auto corner = [&](std::size_t i) { return glm::dvec3(g.positions[t.vertices[i]]); };
            const glm::dvec3 u = corner(1) - corner(0), v = corner(2) - corner(0), n = glm::cross(u, v) / std::sqrt(glm::length(glm::cross(u, v)));
            const glm::dmat4 toWorld(glm::dvec4(u, 0), glm::dvec4(v, 0), glm::dvec4(n, 0), glm::dvec4(corner(0), 1));
            std::vector<float> attributes{float(t.material)};
            for (const std::uint32_t at : t.vertices) {
                const auto take = [&](const auto& list, int components) {
                    for (int c = 0; !list.empty() && c < components; ++c)
                        attributes.push_back(list[at][c]);
                };
                if (!g.normals.empty() && g.normals[at] != glm::vec3(0)) // seen from the node they differ, though equal in the world
                    attributes.push_back(float(&t - g.triangles.data()));
                take(g.uv0, 2);
                take(g.uv1, 2);
                take(g.tangents, 4);
                take(g.colors, 4);
            }
            if (!known.contains(attributes))
                known[attributes] = mesh({t}, toWorld, true);
            node({{"mesh", known[attributes]}}, toWorld);
        }
    }

    void lights() {
        if (scene_.lights.empty())
            return;
        Json list = Json::array();
        for (const PunctualLight& l : scene_.lights) {
            Json j = {{"type", l.kind == PunctualLight::Kind::Point ? "point" : l.kind == PunctualLight::Kind::Spot ? "spot" : "directional"}};
            const float strength = std::max({l.intensity.x, l.intensity.y, l.intensity.z, 1e-6f});
            j["color"] = {l.intensity.x / strength, l.intensity.y / strength, l.intensity.z / strength};
            j["intensity"] = strength;
            if (l.range > 0)
                j["range"] = l.range;
            if (l.kind == PunctualLight::Kind::Spot)
                j["spot"] = {{"innerConeAngle", std::acos(double(l.innerCos))}, {"outerConeAngle", std::acos(double(l.outerCos))}};
            const glm::dvec3 z = -glm::normalize(glm::dvec3(l.direction)), x = glm::normalize(glm::cross(glm::dvec3(0.3, 0.5, 0.8), z));
            const glm::dmat4 toWorld(glm::dvec4(x, 0), glm::dvec4(glm::cross(z, x), 0), glm::dvec4(z, 0), glm::dvec4(glm::dvec3(l.position), 1));
            node({{"extensions", {{"KHR_lights_punctual", {{"light", list.size()}}}}}}, toWorld);
            list.push_back(j);
        }
        file_.json["extensions"]["KHR_lights_punctual"]["lights"] = list;
    }

    void camera() {
        const Camera& c = scene_.cameras[0];
        Json j;
        if (c.orthographic)
            j = {{"type", "orthographic"}, {"orthographic", {{"xmag", c.ymag}, {"ymag", c.ymag}, {"znear", 0.1}, {"zfar", 100}}}};
        else
            j = {{"type", "perspective"}, {"perspective", {{"yfov", c.yfov}, {"znear", 0.1}}}};
        file_.json["cameras"] = {j};
        node({{"camera", 0}}, glm::dmat4(c.toWorld));
    }

    const Scene& scene_;
    FileStyle style_;
    Random& random_;
    TempFolder folder_;
    GltfWriter file_;
    Json roots_ = Json::array();
    std::size_t images_ = 0;
};

} // namespace

bool fitsFile(const Scene& scene) {
    for (const Material& m : scene.materials) {
        const Parameter &color = slot(scene, m, SlotKind::BaseColor), &rough = slot(scene, m, SlotKind::Roughness), &metal = slot(scene, m, SlotKind::Metallic);
        if (rough.textured && metal.textured && !sameAddress(rough, metal))
            return false;
        if (m.alphaMask && m.alphaTexture != ~0u && (!color.textured || !sameAddress(color, scene.alphaTextures[m.alphaTexture])))
            return false;
    }
    return true;
}

Scene throughFile(const Scene& scene, FileStyle style, Random& random) { return FileMaker(scene, style, random).make(); }

} // namespace cmpg::test

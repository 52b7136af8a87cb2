// Materials as tests/reference/make_lobes.py and make_references.py describe them: Mitsuba's plugins.
#pragma once

#include "scene/scene.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace cmpg::test {

inline void setConstant(Scene& scene, const Material& m, SlotKind kind, const std::vector<float>& values) {
    Parameter& p = scene.parameters[m.parameters[std::size_t(kind)]];
    p.width = p.height = 1;
    p.textured = false;
    p.bytes.clear();
    p.channels = std::uint32_t(values.size());
    p.values = values;
}

// Adds a clear coat to a material that has none.
inline void addClearCoat(Scene& scene, Material& m, float factor, float roughness) {
    for (const auto& [kind, value] : {std::pair(SlotKind::Clearcoat, factor), std::pair(SlotKind::ClearcoatRoughness, roughness)}) {
        m.parameters[std::size_t(kind)] = std::uint32_t(scene.parameters.size());
        Parameter p;
        p.name = m.name + "." + slotName(kind);
        p.kind = kind;
        p.channels = 1;
        p.values = {value};
        scene.parameters.push_back(p);
    }
}

// Adds a sheen to a material that has none.
inline void addSheen(Scene& scene, Material& m, const glm::vec3& color, float roughness) {
    for (const SlotKind kind : {SlotKind::SheenRoughness, SlotKind::SheenColor}) {
        m.parameters[std::size_t(kind)] = std::uint32_t(scene.parameters.size());
        Parameter p;
        p.name = m.name + "." + slotName(kind);
        p.kind = kind;
        p.channels = slotChannels(kind);
        p.values = kind == SlotKind::SheenColor ? std::vector<float>{color.x, color.y, color.z} : std::vector<float>{roughness};
        scene.parameters.push_back(p);
    }
}

// Gives the material's clear coat one normal everywhere, of which x and y are given.
inline void addClearcoatNormal(Scene& scene, Material& m, const glm::vec2& normal) {
    m.clearcoatNormals = std::uint32_t(scene.directionTextures.size());
    scene.directionTextures.emplace_back().directions = {normal};
}

// Makes the material's microfacets anisotropic, along the tangent turned counter-clockwise by so many radians.
inline void addAnisotropy(Scene& scene, Material& m, float strength, float rotation) {
    m.parameters[std::size_t(SlotKind::Anisotropy)] = std::uint32_t(scene.parameters.size());
    Parameter p;
    p.name = m.name + "." + slotName(SlotKind::Anisotropy);
    p.kind = SlotKind::Anisotropy;
    p.channels = 1;
    p.values = {strength};
    scene.parameters.push_back(p);
    m.anisotropyDirection = std::uint32_t(scene.directionTextures.size());
    scene.directionTextures.emplace_back().directions = {{0.5f * std::cos(rotation), 0.5f * std::sin(rotation)}};
}

// Makes of the material of this name a blend with another, which keeps its own slots.
inline Parameter& addBlend(Scene& scene, const std::string& name, const std::string& with, float weight) {
    const auto index = [&](const std::string& wanted) {
        for (std::uint32_t m = 0; m < scene.materials.size(); ++m)
            if (scene.materials[m].name == wanted)
                return m;
        throw std::logic_error("no material " + wanted);
    };
    const std::uint32_t first = index(name);
    Material second = scene.materials[index(with)];
    second.name = name + ".second";
    second.parameters[std::size_t(SlotKind::Emission)] = scene.materials[first].parameters[std::size_t(SlotKind::Emission)];
    scene.materials[first].blendWith = std::uint32_t(scene.materials.size());
    second.parameters[std::size_t(SlotKind::Weight)] = scene.materials[first].parameters[std::size_t(SlotKind::Weight)] = std::uint32_t(scene.parameters.size());
    scene.materials.push_back(second);
    Parameter p;
    p.name = name + "." + slotName(SlotKind::Weight);
    p.kind = SlotKind::Weight;
    p.channels = 1;
    p.values = {weight};
    return scene.parameters.emplace_back(p);
}

// A texture of the base colour stays.
inline void replaceMaterial(Scene& scene, const std::string& name, const nlohmann::json& json) {
    for (Material& m : scene.materials) {
        if (m.name != name)
            continue;
        const auto rgb = [&](const char* key) { return glm::vec3(json[key][0], json[key][1], json[key][2]); };
        const std::string model = json["model"];
        if (model == "clearcoat") {
            addClearCoat(scene, m, json["clearcoat"], json["clearcoatRoughness"]);
            return;
        }
        if (model == "sheen") {
            addSheen(scene, m, rgb("sheenColor"), json["sheenRoughness"]);
            return;
        }
        if (model == "anisotropy") {
            addAnisotropy(scene, m, json["anisotropy"], json["rotation"]);
            return;
        }
        m.model = model == "conductor"        ? SurfaceModel::Conductor
                  : model == "plastic"        ? SurfaceModel::Plastic
                  : model == "thindielectric" ? SurfaceModel::ThinDielectric
                                              : SurfaceModel::Dielectric;
        m.smooth = !json.contains("alpha");
        m.microfacets = json.value("distribution", "ggx") == "beckmann" ? Microfacets::Beckmann : Microfacets::Ggx;
        m.roughnessIsAlpha = true;
        m.nonlinear = json.value("nonlinear", false);
        m.hasNormalMap = false;
        if (m.model == SurfaceModel::Conductor) {
            m.eta = rgb("eta");
            m.k = rgb("k");
        } else {
            m.ior = json["ior"];
            setConstant(scene, m, SlotKind::Specular, json["specular"].get<std::vector<float>>());
        }
        if (!scene.parameters[m.parameters[std::size_t(SlotKind::BaseColor)]].textured)
            setConstant(scene, m, SlotKind::BaseColor, json["colour"].get<std::vector<float>>());
        setConstant(scene, m, SlotKind::Roughness, {json.value("alpha", 0.0f)});
        return;
    }
    throw std::logic_error("no material " + name);
}

} // namespace cmpg::test

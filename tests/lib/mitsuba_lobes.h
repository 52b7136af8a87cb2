// The materials whose lobes Mitsuba's plugins have evaluated (tests/reference/make_lobes.py), for the shader library in double precision.
#pragma once

#include "evaluate.h"

#include "scene/coat_table.h"
#include "shader_double.h"

#include <cmath>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <numeric>

namespace cmpg::test {

constexpr std::uint32_t model(std::uint32_t number) { return number << gpu::kModelShift; }

inline glm::dvec3 at(double cosine, double phi = 0.3) {
    const double r = std::sqrt(1 - cosine * cosine);
    return {r * std::cos(phi), r * std::sin(phi), cosine};
}

using shader_double::ShaderLibrary;
constexpr std::size_t kAlphaU = gpu::kSlotAnisotropy - gpu::kCommonSlots; // in Surface::lobe

// What make_lobes.py says of a material.
struct MitsubaMaterial {
    ShaderLibrary library;
    ShaderLibrary::Surface surface;
    double alpha = 0;

    explicit MitsubaMaterial(const nlohmann::json& m) {
        const auto rgb = [&](const char* key) {
            return m.contains(key) ? glm::dvec3(m[key][0].get<double>(), m[key][1].get<double>(), m[key][2].get<double>()) : glm::dvec3(1);
        };
        const std::string kind = m["model"];
        const double alphaV = m.value("alpha_v", m.value("alpha", 0.0)), alphaU = m.value("alpha_u", alphaV);
        alpha = std::min(alphaU, alphaV);
        const Microfacets microfacets = m.value("distribution", "ggx") == "beckmann" ? Microfacets::Beckmann : Microfacets::Ggx;
        surface = {rgb("colour"), alphaV, 0, 0, rgb("specular"), m.value("ior", 1.5), 0, 0};
        std::uint32_t flags = (alpha > 0 ? 0 : gpu::kMaterialSmooth) | (microfacets == Microfacets::Beckmann ? gpu::kMaterialBeckmann : 0);
        if (m.value("nonlinear", false)) flags |= gpu::kMaterialNonlinear;
        if (kind == "conductor") {
            flags |= model(gpu::kModelConductor);
            const glm::dvec3 eta = rgb("eta");
            surface.metallic = eta.x;
            surface.specular = eta.y;
            surface.ior = eta.z;
            surface.specularColor = rgb("k");
        } else if (kind == "plastic") {
            flags |= model(gpu::kModelPlastic);
            if (alpha > 0)
                addCoat(microfacets);
            else
                surface.metallic = CoatTable::reflectedDiffuse(1 / surface.ior);
        } else {
            flags |= model(kind == "dielectric" ? gpu::kModelDielectric : gpu::kModelThinDielectric);
        }
        if (m.contains("alpha_u")) {
            flags |= gpu::kMaterialAnisotropic;
            surface.lobe[kAlphaU] = alphaU;
            surface.tangent = {1, 0, 0};
        }
        surface.model = flags;
    }

    void addCoat(Microfacets microfacets) {
        std::vector<glm::vec4> texels(std::size_t(gpu::kCoatRows) * gpu::kCoatColumns);
        CoatTable(surface.ior, microfacets).write(0, gpu::kCoatRows - 1, texels);
        library.coatTexels.assign(texels.begin(), texels.end());
    }
};

inline nlohmann::json lobes() {
    std::ifstream file(std::string(CMPG_SOURCE_DIR) + "/tests/reference/lobes.json");
    return nlohmann::json::parse(file);
}

inline glm::dvec3 vec(const nlohmann::json& v) { return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()}; }

inline std::vector<nlohmann::json> materialsOfPairs(bool dielectrics) {
    std::vector<nlohmann::json> result;
    const nlohmann::json all = lobes();
    for (const auto& set : all["pairs"])
        if ((set["material"]["model"] == "dielectric") == dielectrics) result.push_back(set["material"]);
    return result;
}

inline glm::dvec3 difference(const std::function<glm::dvec3(double)>& f, double step) {
    const auto central = [&](double h) { return (f(h) - f(-h)) / (2 * h); };
    return (4.0 * central(step / 2) - central(step)) / 3.0;
}

inline void expectNear(const glm::dvec3& found, const glm::dvec3& expected, const glm::dvec3& scale, const std::string& what) {
    for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(found[c], expected[c], 1e-5 * scale[c] + 1e-9) << what << " channel " << c;
}

inline double total(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

inline Query query(const MitsubaMaterial& m, const glm::vec3& wo) {
    Query q;
    q.baseColor = m.surface.baseColor;
    q.roughness = float(m.surface.roughness);
    q.metallic = float(m.surface.metallic);
    q.specular = float(m.surface.specular);
    q.specularColor = m.surface.specularColor;
    q.ior = float(m.surface.ior);
    q.model = m.surface.model;
    q.wo = wo;
    q.anisotropy = float(m.surface.lobe[kAlphaU]);
    q.tangent = m.surface.tangent;
    return q;
}

} // namespace cmpg::test

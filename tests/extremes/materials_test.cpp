// Values, densities and derivatives of materials from mirrors to chalk, from normal to grazing incidence, from black to white.
#include "lib/evaluate.h"
#include "worst.h"

#include <array>
#include <glm/gtc/constants.hpp>
#include <sstream>
#include <vector>

namespace cmpg::test {
namespace {

constexpr float kRoughness[] = {0, 1e-40f, 1e-4f, 1e-3f, 1e-2f, 0.0316f, 0.0317f, 0.05f, 0.1f, 0.3f, 0.6f, 1};
constexpr float kAlbedo[] = {0, 1e-40f, 1e-6f, 0.5f, 1};
constexpr double kIncidence[] = {0, 1e-4, 30, 60, 85, 89, 89.9, 89.99, 89.999, 89.9999}; // degrees

struct Material {
    float metallic, specular, ior;
    glm::vec3 specularColor{1};
};
const Material kMaterials[] = {{1, 1, 1.5f},    {0, 1, 1.5f}, {0, 0, 1.5f},       {0.5f, 0.7f, 1.33f},
                               {1e-6f, 1, 1.5f}, {0, 1, 1},    {0, 1, 0},          {1 - 6e-8f, 1, 2.4f, glm::vec3(0, 1e-6f, 30)}};

glm::dvec3 direction(double degrees, double turn) {
    const double theta = degrees * glm::pi<double>() / 180;
    return {std::sin(theta) * std::cos(turn), std::sin(theta) * std::sin(turn), std::cos(theta)};
}

std::string describe(const Query& q, double out, double in, double turn) {
    std::ostringstream s;
    s << "roughness " << q.roughness << " albedo " << q.baseColor.y << " metallic " << q.metallic << " specular " << q.specular << " ior "
      << q.ior << " angles " << out << ", " << in << " turn " << turn;
    return s.str();
}

// Every material at every pair of angles, in the plane of incidence and out of it, with the shading frame along z and askew.
template <class Visit> void sweep(Visit&& visit) {
    const glm::dvec3 askew = glm::normalize(glm::dvec3(0.3, -0.7, 0.5));
    const glm::dvec3 x = glm::normalize(glm::cross(askew, glm::dvec3(1, 0, 0)));
    const glm::dmat3 frames[] = {glm::dmat3(1), glm::dmat3(x, glm::cross(askew, x), askew)};
    for (const Material& m : kMaterials)
        for (const float roughness : kRoughness)
            for (const float albedo : kAlbedo)
                for (const double out : kIncidence)
                    for (const double in : kIncidence)
                        for (const double turn : {3.141592653589793, 3.1405, 3.0, 1.0, 1e-3, 0.0})
                            for (const glm::dmat3& frame : frames) {
                                Query q;
                                q.metallic = m.metallic;
                                q.specular = m.specular;
                                q.ior = m.ior;
                                q.specularColor = m.specularColor;
                                q.roughness = roughness;
                                q.baseColor = {0.25f, albedo, 1};
                                q.normal = frame[2];
                                q.wo = frame * direction(out, 0);
                                q.wi = frame * direction(in, turn);
                                visit(q, out, in, turn);
                            }
}

// The smaller cosine as both builds see it.
double smallerCosine(const Query& q) {
    const glm::dvec3 n(q.normal);
    return std::min(std::abs(glm::dot(n, glm::dvec3(q.wo))), std::abs(glm::dot(n, glm::dvec3(q.wi))));
}

TEST(ExtremeMaterials, ValuesAndDensities) {
    const std::string range = "roughness 0, 1e-4 to 1; incidence to 89.9999 degrees; albedo 0, 1e-6, 1";
    Worst value("material | f cos | " + range, "float64", 1e-4), pdf("material | density | " + range, "float64", 1e-4);
    sweep([&](const Query& q, double out, double in, double turn) {
        const Evaluation got = evaluateFloat(q), truth = evaluateDouble(q);
        const auto where = [&] {
            std::ostringstream s;
            s << describe(q, out, in, turn) << " cosine " << smallerCosine(q) << " value " << got.value.y << " truth " << truth.value.y << " pdf " << got.pdf << " truth " << truth.pdf;
            return s.str();
        };
        for (int c = 0; c < 3; ++c) value.compare(got.value[c], truth.value[c], where);
        pdf.compare(got.pdf, truth.pdf, where);
    });
}

TEST(ExtremeMaterials, Derivatives) {
    const std::string range = "roughness 0, 1e-4 to 1; incidence to 89.9999 degrees; albedo 0, 1e-6, 1";
    Worst color("material | d baseColor | " + range, "float64", 1e-4), rough("material | d roughness | " + range, "float64", 1e-4);
    Worst metal("material | d metallic | " + range, "float64", 1e-4), specular("material | d specular | " + range, "float64", 1e-4);
    Worst normal("material | d normal | " + range, "float64", 1e-4);
    sweep([&](const Query& q, double out, double in, double turn) {
        const Evaluation got = evaluateFloat(q), truth = evaluateDouble(q);
        const auto where = [&] {
            std::ostringstream s;
            s << describe(q, out, in, turn) << " cosine " << smallerCosine(q);
            return s.str();
        };
        for (int c = 0; c < 3; ++c) {
            const double f = truth.value[c];
            color.compare(got.baseColor[c], truth.baseColor[c], where);
            // Terms of opposite sign meet where a derivative crosses zero: relative to the terms.
            rough.compare(got.roughness[c], truth.roughness[c], where, 2 * f / std::max(1e-3, double(q.roughness)));
            metal.compare(got.metallic[c], truth.metallic[c], where, f);
            specular.compare(got.specular[c], truth.specular[c], where, f);
            const double length = glm::length(truth.normal[c]);
            const double error = glm::length(got.normal[c] - truth.normal[c]);
            normal.add(error <= 1e-30 ? 0 : error / std::max(length, f), where);
        }
    });
}

} // namespace
} // namespace cmpg::test

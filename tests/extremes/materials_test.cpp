// Values, densities and derivatives of materials from mirrors to chalk, from normal to grazing incidence, from black to white.
#include "lib/evaluate.h"
#include "support/evaluate_device.h"
#include "support/render_fixture.h"
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

// Angles of the two directions with the normal, and between them around it.
struct Pair {
    double out, in, turn;
};

std::string describe(const Query& q, const Pair& pair) {
    std::ostringstream s;
    s << "roughness " << q.roughness << " albedo " << q.baseColor.y << " metallic " << q.metallic << " specular " << q.specular << " ior "
      << q.ior << " angles " << pair.out << ", " << pair.in << " turn " << pair.turn;
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
                                visit(q, Pair{out, in, turn});
                            }
}

const char* const kRange = " | roughness 0, 1e-4 to 1; incidence to 89.9999 degrees; albedo 0, 1e-6, 1";

// The errors of everything a material says of a pair of directions. Where terms of opposite sign meet, relative to the terms.
class Errors {
  public:
    explicit Errors(const std::string& by)
        : value_(row(by, "f cos")), pdf_(row(by, "density")), color_(row(by, "d baseColor")), rough_(row(by, "d roughness")), metal_(row(by, "d metallic")),
          specular_(row(by, "d specular")), normal_(row(by, "d normal")) {}

    void add(const Query& q, const Evaluation& got, const std::string& where) {
        const Evaluation truth = evaluateDouble(q);
        const auto here = [&] { return where; };
        pdf_.compare(got.pdf, truth.pdf, here);
        for (int c = 0; c < 3; ++c) {
            const double f = truth.value[c];
            value_.compare(got.value[c], f, here);
            color_.compare(got.baseColor[c], truth.baseColor[c], here);
            rough_.compare(got.roughness[c], truth.roughness[c], here, 2 * f / std::max(1e-3, double(q.roughness)));
            metal_.compare(got.metallic[c], truth.metallic[c], here, f);
            specular_.compare(got.specular[c], truth.specular[c], here, f);
            const double error = glm::length(got.normal[c] - truth.normal[c]);
            normal_.add(error <= 1e-30 ? 0 : error / std::max(glm::length(truth.normal[c]), f), here);
        }
    }

  private:
    static Worst row(const std::string& by, const char* what) { return Worst("material, " + by + " | " + what + kRange, "float64", 1e-4); }
    Worst value_, pdf_, color_, rough_, metal_, specular_, normal_;
};

TEST(ExtremeMaterials, FloatBuild) {
    Errors errors("float build");
    sweep([&](const Query& q, const Pair& pair) { errors.add(q, evaluateFloat(q), describe(q, pair)); });
}

// Every tenth of them: the arithmetic is the float build's, but for what the device does to it.
TEST(ExtremeMaterials, Device) {
    Errors errors("device");
    std::vector<Query> queries;
    std::vector<std::string> where;
    std::size_t i = 0;
    sweep([&](const Query& q, const Pair& pair) {
        if (i++ % 11) return;
        queries.push_back(q);
        where.push_back(describe(q, pair));
    });
    const auto results = evaluateOn<BsdfResult>(device(), "evaluate_bsdf", queries);
    for (i = 0; i < queries.size(); ++i) {
        const BsdfResult& r = results[i];
        errors.add(queries[i], {r.valueWithDerivatives, double(r.pdf), r.baseColor, r.roughness, r.metallic, r.specular, r.normal()}, where[i]);
    }
}

} // namespace
} // namespace cmpg::test

// Directions drawn from materials at the ends of their ranges: every one has a density, and the light they stand for has no bias.
#include "calls.h"
#include "worst.h"

#include <glm/gtc/constants.hpp>
#include <random>
#include <sstream>

namespace cmpg::test {
namespace {

// The same random numbers through the float and the double build. One sample may end elsewhere, on the other side of a decision; the
// means over many may not. The density is that of the direction the float build has, whatever led there.
TEST(ExtremeSampling, WeightsHaveNoBias) {
    const std::string range = " | roughness 0, 1e-4 to 1; incidence to 89.9999 degrees; albedo 0, 1e-6, 1";
    Bias bias("material | mean weight of drawn directions" + range, "float64, the same random numbers");
    Worst density("material | density of drawn directions" + range, "float64", 1e-4), lost("material | drawn directions without density or of infinite weight" + range, "0", 0);
    std::mt19937 random(23);
    const auto uniform = [&] { return float(random() >> 8) * 0x1p-24f; };
    struct Material {
        float metallic, specular;
    };
    for (const Material& m : {Material{1, 1}, Material{0, 1}, Material{0, 0}, Material{0.5f, 0.7f}})
        for (const float roughness : {0.0f, 1e-4f, 0.0317f, 0.1f, 0.4f, 1.0f})
            for (const float albedo : {0.0f, 1e-6f, 1.0f})
                for (const double degrees : {0.0, 60.0, 89.0, 89.99, 89.9999}) {
                    Query q;
                    q.metallic = m.metallic;
                    q.specular = m.specular;
                    q.roughness = roughness;
                    q.baseColor = {albedo, 0.5f, 1};
                    const double theta = degrees * glm::pi<double>() / 180;
                    const glm::dvec3 n = glm::normalize(glm::dvec3(0.3, -0.7, 0.5)), x = glm::normalize(glm::cross(n, glm::dvec3(1, 0, 0)));
                    q.normal = n;
                    q.wo = std::cos(theta) * n + std::sin(theta) * x;
                    constexpr int kSamples = 2000;
                    double sum = 0, squares = 0, truth = 0;
                    const auto where = [&] {
                        std::ostringstream s;
                        s << "metallic " << m.metallic << " specular " << m.specular << " roughness " << roughness << " albedo " << albedo << " angle " << degrees << " difference "
                          << sum / kSamples << " of " << truth / kSamples;
                        return s.str();
                    };
                    for (int i = 0; i < kSamples; ++i) {
                        const std::array<float, 3> u{uniform(), uniform(), uniform()};
                        const Drawn ours = sampleFloat(q, u), exact = sampleDouble(q, u);
                        const double weight = ours.any ? (ours.weight.x + ours.weight.y + ours.weight.z) / 3 : 0;
                        lost.add(ours.any && !(ours.density > 0 && std::isfinite(ours.density) && std::isfinite(weight)) ? 1 : 0, where);
                        const double should = exact.any ? (exact.weight.x + exact.weight.y + exact.weight.z) / 3 : 0;
                        const double difference = weight - should;
                        sum += difference;
                        squares += difference * difference;
                        truth += should;
                        if (!ours.any) continue;
                        q.wi = ours.wi;
                        density.compare(ours.density, evaluateDouble(q).pdf, where);
                    }
                    const double mean = sum / kSamples, error = std::sqrt(std::max(0.0, squares / kSamples - mean * mean) / kSamples);
                    bias.add(mean, error, 0, 1e-5 * truth / kSamples, where); // what a weight is rounded by, which may be alike in all of them
                }
}

} // namespace
} // namespace cmpg::test

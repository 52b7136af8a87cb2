// Images and derivatives against Mitsuba 3, stored with their standard errors by tests/reference/make_references.py.
#include "support/material_json.h"
#include "support/render_fixture.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

namespace cmpg::test {
namespace {

const std::string kFolder = std::string(CMPG_SOURCE_DIR) + "/tests/reference/";

nlohmann::json references() {
    std::ifstream file(kFolder + "references.json");
    return nlohmann::json::parse(file)["references"];
}

// Mean and squared standard error of every value over independent seeds.
struct Estimate {
    int width = 0, height = 0, channels = 0;
    std::vector<double> mean, variance;
};

Estimate reduce(int width, int height, int channels, const std::vector<std::vector<double>>& runs) {
    Estimate e{width, height, channels, std::vector<double>(runs[0].size(), 0.0), std::vector<double>(runs[0].size(), 0.0)};
    const double n = double(runs.size());
    for (std::size_t i = 0; i < e.mean.size(); ++i) {
        for (const auto& run : runs)
            e.mean[i] += run[i] / n;
        for (const auto& run : runs)
            e.variance[i] += (run[i] - e.mean[i]) * (run[i] - e.mean[i]) / (n * (n - 1));
    }
    return e;
}

Scene sceneOf(const nlohmann::json& r) {
    const std::string name = r["scene"];
    if (name.starts_with("mitsuba/"))
        return loadScene(kFolder + name + ".xml");
    Scene scene = bundledScene(name);
    if (r.contains("materials"))
        for (const auto& [replaced, material] : r["materials"].items())
            replaceMaterial(scene, replaced, material);
    return scene;
}

// `share`: of the reference's samples per pixel.
Estimate ours(const nlohmann::json& r, double share) {
    const std::string what = r["what"];
    RenderConfig config;
    config.maxDepth = r["maxDepth"];
    std::vector<std::string> parameters;
    if (r.contains("parameter"))
        parameters.push_back(r["parameter"]);
    Bench b(sceneOf(r), parameters, config);
    const glm::uvec2 size = b.scene.cameras.front().size.value_or(glm::uvec2(64));
    const View view = viewOf(b.scene, int(size.x), int(size.y));
    const std::uint32_t spp = std::max(1u, std::uint32_t(share * r["spp"].get<double>())), seeds = r["seeds"].get<std::uint32_t>() / 2; // half the reference's work is enough for a verdict
    std::vector<std::vector<float>> direction = b.ones();
    if (what == "self")
        direction[0] = b.scene.parameters[b.config.differentiable[0]].values;
    Image adjoint;
    if (what == "reverse")
        adjoint = readImage(kFolder + std::string(r["adjoint"])).image;

    std::vector<std::vector<double>> runs;
    for (std::uint32_t seed = 0; seed < seeds; ++seed) {
        if (what == "reverse") {
            std::vector<std::vector<double>> gradients;
            b.renderer->reverse(view, spp, {seed, 0, 1}, adjoint, {}, {}, gradients);
            runs.push_back(gradients[0]);
            continue;
        }
        const Image image = what == "image" ? b.renderer->render(view, spp, {seed, 0, 0})
                                            : b.renderer->forward(view, spp, {seed, 0, 1}, b.config.differentiable, direction);
        runs.emplace_back(image.values.begin(), image.values.end());
    }
    if (what != "reverse")
        return reduce(view.width, view.height, 3, runs);
    const Parameter& p = b.scene.parameters[b.config.differentiable[0]];
    return reduce(int(p.width), int(p.height), int(p.channels), runs);
}

// A derivative read through bilinear interpolation falls on four texels at once, with weights whose squares add up to 4/9 on average:
// sums of neighbouring texels vary that much more than the texels' own errors tell.
double texelCovariance(const nlohmann::json& r) {
    if (r["what"] != "reverse")
        return 1;
    const Scene scene = sceneOf(r);
    const Parameter& p = scene.parameters[scene.parameter(r["parameter"])];
    return p.width * p.height > 1 && !p.nearest ? 9.0 / 4.0 : 1.0;
}

Estimate theirs(const nlohmann::json& r, int channels) {
    const Image mean = readImage(kFolder + std::string(r["file"])).image, error = readImage(kFolder + std::string(r["error"])).image;
    Estimate e{mean.width, mean.height, channels, {}, {}};
    // A scalar parameter is stored as three equal channels.
    for (std::size_t i = 0; i < mean.pixels(); ++i)
        for (int c = 0; c < channels; ++c) {
            e.mean.push_back(mean.values[i * std::size_t(mean.channels) + std::size_t(c)]);
            const double s = error.values[i * std::size_t(error.channels) + std::size_t(c)];
            e.variance.push_back(s * s);
        }
    return e;
}

// Bars of the whole, in joint standard errors, and of the mean square of blocks' differences. The squares of normal scores average 0.76 without the 5 % largest,
// 0.85 with errors from 8 and 16 seeds; 1.35 is more than four standard deviations of that average for 64 independent blocks.
constexpr double kWholeBar = 4, kBlockBar = 1.35;
constexpr int kBlocks = 8; // along an edge

// Differences of block means over their joint standard errors; blocks without any signal are left out.
std::vector<double> blockScores(const Estimate& a, const Estimate& b, int blocks, double covariance) {
    std::vector<double> scores;
    for (int by = 0; by < blocks; ++by)
        for (int bx = 0; bx < blocks; ++bx)
            for (int c = 0; c < a.channels; ++c) {
                double difference = 0, variance = 0, sum = 0;
                for (int y = by * a.height / blocks; y < (by + 1) * a.height / blocks; ++y)
                    for (int x = bx * a.width / blocks; x < (bx + 1) * a.width / blocks; ++x) {
                        const std::size_t i = (std::size_t(y) * std::size_t(a.width) + std::size_t(x)) * std::size_t(a.channels) + std::size_t(c);
                        difference += a.mean[i] - b.mean[i];
                        variance += covariance * (a.variance[i] + b.variance[i]);
                        sum += b.mean[i];
                    }
                variance += 1e-10 * sum * sum; // single precision, where nothing is random
                if (variance > 0)
                    scores.push_back(std::abs(difference) / std::sqrt(variance));
            }
    return scores;
}

// Mean square without the 5 % largest, which are heavy tails' privilege.
double usualSquare(std::vector<double> scores) {
    std::sort(scores.begin(), scores.end());
    const std::size_t kept = scores.size() - scores.size() / 20;
    return std::accumulate(scores.begin(), scores.begin() + std::ptrdiff_t(kept), 0.0, [](double sum, double score) { return sum + score * score; }) / double(kept);
}

void expectAgreement(const std::string& name, double share) {
    const nlohmann::json r = references()[name];
    const Estimate a = ours(r, share), b = theirs(r, a.channels);
    ASSERT_EQ(a.mean.size(), b.mean.size());
    const double covariance = texelCovariance(r);

    for (int c = 0; c < a.channels; ++c) {
        double mean = 0, difference = 0, variance = 0;
        for (std::size_t i = std::size_t(c); i < a.mean.size(); i += std::size_t(a.channels)) {
            mean += b.mean[i];
            difference += a.mean[i] - b.mean[i];
            variance += a.variance[i] + b.variance[i];
        }
        const double error = std::sqrt(covariance * variance);
        // Four joint standard errors; both sides sum in single precision.
        EXPECT_LE(std::abs(difference), kWholeBar * error + 1e-5 * std::abs(mean)) << "channel " << c << ": " << difference / mean * 100 << " % off";
        // 1 % where the references resolve it (three standard errors below it).
        if (3 * error < 0.01 * std::abs(mean)) {
            EXPECT_LE(std::abs(difference), 0.01 * std::abs(mean)) << "channel " << c;
        }
    }

    if (kBlocks > std::min(a.width, a.height))
        return;
    const std::vector<double> scores = blockScores(a, b, kBlocks, covariance);
    ASSERT_FALSE(scores.empty());
    EXPECT_LE(usualSquare(scores), kBlockBar);
    EXPECT_LE(*std::max_element(scores.begin(), scores.end()), 12) << "a block that no tail explains";
}

// A result of half the size, as noisy as the reference, would not pass.
TEST(References, TellHalfFromWhole) {
    const nlohmann::json all = references();
    for (const auto& [name, r] : all.items()) {
        const int channels = readImage(kFolder + std::string(r["file"])).image.channels;
        const Estimate b = theirs(r, channels);
        Estimate a = b;
        for (double& mean : a.mean)
            mean /= 2;
        const double covariance = texelCovariance(r);
        double whole = 0; // of the channel that tells most
        for (int c = 0; c < channels; ++c) {
            double difference = 0, variance = 0;
            for (std::size_t i = std::size_t(c); i < a.mean.size(); i += std::size_t(channels)) {
                difference += a.mean[i] - b.mean[i];
                variance += covariance * (a.variance[i] + b.variance[i]);
            }
            whole = std::max(whole, std::abs(difference) / std::sqrt(variance));
        }
        const double blocks = kBlocks > std::min(a.width, a.height) ? 0 : usualSquare(blockScores(a, b, kBlocks, covariance));
        EXPECT_TRUE(whole > kWholeBar || blocks > kBlockBar) << name << ": " << whole << ", " << blocks;
    }
}

class Mitsuba : public testing::TestWithParam<std::string> {};
class MitsubaFewSamples : public testing::TestWithParam<std::string> {};

TEST_P(Mitsuba, Agrees) { expectAgreement(GetParam(), 1); }
// For devices that are slow: the same bars, wider errors. Larger faults of a driver than a few per cent show.
TEST_P(MitsubaFewSamples, Agrees) { expectAgreement(GetParam(), 1.0 / 16); }

// Long, and what they tell is told sooner by a quick one: the derivative by the same parameter in the other mode (both modes contract the same samples, which
// ForwardAgreesWithReverse holds slot by slot), by the same slot of another scene of the same kind, or of the same lobe.
const std::set<std::string> kRepeated = {
    "bowl_table.baseColor_one", "bowl_table.baseColor_reverse",                     // box_white.baseColor_one: matt; the caustic is in bowl_image
    "bowl_bowl.baseColor_self",                                                     // environment_steel.baseColor_one: metal
    "box_left.baseColor_reverse", "box_painting.baseColor_one",                     // box_white.baseColor_one, box_painting.baseColor_reverse
    "brushed_varied.anisotropy_reverse", "brushed_wavy.anisotropy_one",             // brushed_varied.anisotropy_one
    "brushed_wavy.normal_reverse", "brushed_wavy.normal_one",                       // materials_wavy.normal_one
    "coats_brass.baseColor_one", "coats_half.baseColor_one",                        // coats_brass.baseColor_reverse, metals_plastic.baseColor_one
    "coats_half.specular_one",                                                      // materials_varied.specular_one
    "door_image",                                                                   // box_image
    "environment_environment.radiance_self", "materials_environment.radiance_one", // environment_environment.radiance_reverse
    "environment_painting.baseColor_one", "environment_painting.baseColor_reverse", // box_painting.baseColor_reverse; the light is in environment_image
    "environment_ball.specular_self",                                               // materials_plastic.specular_self
    "glass_pane.baseColor_one",                                                     // glass_ball.baseColor_one; what a thin wall lets through is in the image
    "glass_painting.baseColor_one", "glass_white.baseColor_one",                    // glass_painting.baseColor_reverse: matt, seen through glass
    "materials_half.metallic_one", "materials_half.metallic_reverse",               // materials_varied.metallic_one
    "materials_lamp.emission_one", "materials_wavy.normal_reverse",                 // the other mode
    "metals_plastic.baseColor_reverse",                                             // metals_plastic.baseColor_one
    "mitsuba_brushed_steel.alpha_v_one", "mitsuba_brushed_gold.anisotropic_one",    // mitsuba_brushed_steel.alpha_u_one
    "mitsuba_brushed_patterned.alpha_u_reverse",                                    // the same
    "mitsuba_blends_rusty.weight_one",                                              // the same in reverse
    "mitsuba_covers_ground.reflectance_one",                                        // mitsuba_covers_veil.reflectance_one; what lets light through is in the image
    "mitsuba_emitters_red.reflectance_one", "mitsuba_shapes_red.reflectance_one",   // box_white.baseColor_one: matt; lights and shapes are in the images
    "varnish_half.clearcoat_one", "varnish_brass.clearcoat_one",                    // varnish_half.clearcoat_reverse
    "velvet_half.sheenColor_one",                                                   // the same in reverse
    "velvet_brass.sheenRoughness_one",                                              // velvet_half.sheenColor_reverse; frozen differences are as the derivative
    "glass_ball.specular_one", "metals_plastic.specular_one",                       // what is reflected is in the images; frozen differences as above
    "mitsuba_blends_both.weight_one",                                               // mitsuba_blends_rusty.weight_reverse
    "environment_steel.baseColor_one",                                              // metals_brass.baseColor_one
};

// The noisy ones need many samples: with the repeated ones, they are the long tests.
std::vector<std::string> names(bool full) {
    std::vector<std::string> chosen;
    const nlohmann::json r = references();
    for (const std::string& name : kRepeated)
        if (!r.contains(name))
            throw std::logic_error("there is no reference " + name);
    for (const auto& [name, value] : r.items())
        if (((value["what"] != "image" && value["spp"] > 128) || kRepeated.contains(name)) == full)
            chosen.push_back(name);
    return chosen;
}

std::string testName(const testing::TestParamInfo<std::string>& reference) {
    std::string name = reference.param;
    std::replace_if(name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
    return name;
}

INSTANTIATE_TEST_SUITE_P(References, Mitsuba, testing::ValuesIn(names(false)), testName);
INSTANTIATE_TEST_SUITE_P(References, MitsubaFewSamples, testing::Values("box_image", "box_white.baseColor_one", "box_painting.baseColor_reverse"), testName);
INSTANTIATE_TEST_SUITE_P(FullReferences, Mitsuba, testing::ValuesIn(names(true)), testName);

} // namespace
} // namespace cmpg::test

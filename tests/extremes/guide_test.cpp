// The guide's maps and mixtures at the ends of their ranges.
#include "calls.h"
#include "shared/guide.h"
#include "worst.h"

#include <glm/gtc/constants.hpp>
#include <random>
#include <sstream>

namespace cmpg::test {
namespace {

using namespace gpu;

TEST(ExtremeGuide, PolesAndWrapAround) {
    std::vector<glm::vec3> directions{{0, 0, 1}, {0, 0, -1}, {-0.0f, -0.0f, 1}, {1e-40f, -1e-40f, -1}, {1, 0, 0}, {1, -1e-30f, 0}, {1, -1e-40f, 0}, {-1, -0.0f, 0}, {-1, 0, 0}};
    for (const double tilt : {1e-20, 1e-8, 1e-6, 1e-4, 3.5e-4, 0.01, 1.0})
        for (const double turn : {0.0, 1e-8, 1e-7, 3.1415926, 3.141592653589793, -3.1415926, -1e-7, -1e-8, 2.0})
            for (const double sign : {1.0, -1.0})
                directions.emplace_back(glm::dvec3(std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), sign * std::cos(tilt)));
    Worst square("guide | direction to square | poles, both sides of the seam", "float64", 1e-6);
    Worst back("guide | and back, per 4.9e-4 | the same", "the direction", 2);
    for (const glm::vec3& d : directions) {
        const Numbers got = callFloat(Function::SquareFromDirection, {d.x, d.y, d.z}), truth = callDouble(Function::SquareFromDirection, {d.x, d.y, d.z});
        const auto where = [&] {
            std::ostringstream s;
            s << d.x << ' ' << d.y << ' ' << d.z << ": " << got[0] << ' ' << got[1] << " truth " << truth[0] << ' ' << truth[1];
            return s.str();
        };
        const double turn = std::abs(got[0] - truth[0]);
        square.add(got[0] >= 0 && got[0] < 1 && got[1] >= 0 && got[1] < 1 ? std::min(turn, 1 - turn) : 1, where);
        square.add(std::abs(got[1] - truth[1]), where);
        const Numbers again = callFloat(Function::DirectionFromSquare, {float(got[0]), float(got[1])});
        // The square resolves 6e-8 of the sphere: a cap of 4.9e-4 at a pole.
        const double distance = glm::length(glm::dvec3(again[0], again[1], again[2]) - glm::dvec3(d));
        back.add(distance / 4.9e-4, where);
    }
    Worst unit("guide | square to direction, length | corners and edges", "1", 1e-6);
    for (const float x : {0.0f, 1e-40f, 6e-8f, 0.5f, 0.99999994f})
        for (const float y : {0.0f, 1e-40f, 1e-30f, 6e-8f, 0.5f, 0.99999994f}) {
            const Numbers d = callFloat(Function::DirectionFromSquare, {x, y});
            unit.add(std::abs(std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - 1), [&] { return std::to_string(x) + ' ' + std::to_string(y); });
        }
}

// What is drawn from has a density, what has none is not drawn, and both builds agree on it. Tables with masses of 1e-30 to 1e30, with
// only some of P, D+, D-, and with none.
TEST(ExtremeGuide, Mixtures) {
    const std::string range = "masses 1e-30 to 1e30, all-zero, one-sided; weights 0, 1e-30, 1e-6, 1, 1e30; all kinds and signs";
    Worst density("guide | density | " + range, "float64", 1e-4), again("guide | density asked for alone | " + range, "the draw's", 1e-6);
    Worst score("guide | score | " + range, "float64", 1e-4);
    std::mt19937 random(17);
    std::size_t nothing = 0, borders = 0;
    for (std::uint32_t seed = 0; seed < 64; ++seed) {
        const GuideTable table = randomTable(seed, seed % 2 ? 30 : 3, seed / 2 % 8);
        for (const std::uint32_t kind : {kGuidePrimal, kGuideDifferential, kGuideUniform, kGuideConditional})
            for (const int sign : {0, 1, -1})
                for (const float light : {0.0f, 1e-40f, 1e-30f, 1e-6f, 1.0f, 1e30f})
                    for (const float derivative : {0.0f, 1e-40f, 1e-30f, 1e-6f, 1.0f, 1e30f}) {
                        const Mixture mixture{kind, sign, light, derivative};
                        const auto uniform = [&] { return float(random() >> 8) * 0x1p-24f; };
                        const glm::vec3 u(uniform(), random() % 4 ? uniform() : random() % 2 ? 0.0f : 0.99999994f, uniform());
                        const GuideDraw draw = drawFloat(table, 0, mixture, u);
                        const GuideDraw truth = followDouble(table, 0, mixture, glm::vec2(draw.point));
                        const auto where = [&] {
                            std::ostringstream s;
                            s << "table " << seed << " kind " << kind << " sign " << sign << " weights " << light << ", " << derivative << " u " << u.x << ' ' << u.y
                              << " score " << draw.score << " truth " << truth.score << " density " << draw.density << " truth " << truth.density;
                            return s.str();
                        };
                        score.compare(draw.score, truth.score, where, 0, 1e-20); // up to there a cell knows nothing
                        if (draw.score <= 1e-20) {
                            ++nothing;
                            continue;
                        }
                        density.add(draw.density > 0 ? 0 : 1, where);
                        again.compare(draw.again, draw.density, where);
                        if (truth.leaf != draw.leaf) ++borders; // a point on a border
                        else density.compare(draw.density, truth.density, where);
                    }
    }
    EXPECT_GT(nothing, 500u);
    EXPECT_LT(borders, density.count() / 1000);
}

} // namespace
} // namespace cmpg::test

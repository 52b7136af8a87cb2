// Maps that step together: blocks of texels against matrices written out, what they find that maps on their own do not, and which maps an optimisation couples.
#include "linear_model.h"
#include "optimize/coupled_maps.h"
#include "optimize/gauss_newton.h"

#include <gtest/gtest.h>
#include <iostream>
#include <numeric>

namespace cmpg::test {
namespace {

constexpr std::uint32_t kEdge = 6;
constexpr std::size_t kTexels = kEdge * kEdge, kBlock = 5, kCross = CrossCurvature::count(kBlock);

// A colour, a roughness and a metalness. Every texel has nine measurements of its own: three views of three channels. Colour's channel c tells in channel c alone, and
// what metalness does is nearly what less colour does.
struct Maps {
    explicit Maps(double scale = 1) : scale_(scale) {
        std::mt19937 random(11);
        std::uniform_real_distribution<double> uniform(0, 1);
        for (const auto& [kind, channels] : {std::pair{SlotKind::BaseColor, 3u}, {SlotKind::Roughness, 1u}, {SlotKind::Metallic, 1u}}) {
            maps.push_back(makeParameter("m." + std::to_string(maps.size()), kind, kEdge, kEdge, channels, 0.5f));
            for (std::size_t i = 0; i < kTexels * channels; ++i)
                truth.push_back(0.3 + 0.4 * uniform(random));
        }
        for (std::size_t i = 0; i < kTexels * 9; ++i) {
            const double colour = 0.6 + 0.8 * uniform(random);
            derivatives.push_back({colour, 0.3 * (uniform(random) - 0.3), -0.5 * colour + 0.06 * (uniform(random) - 0.5)});
        }
        OptimizerConfig config;
        config.kind = OptimizerKind::GaussNewton;
        for (const Parameter& map : maps)
            moments.push_back(initialMoments(config, map));
    }

    static std::size_t first(std::size_t map) { return map == 0 ? 0 : (2 + map) * kTexels; } // of all entries
    // Of a measurement by the entries of its texel's block.
    std::array<double, kBlock> row(std::size_t measurement) const {
        const auto& [colour, roughness, metallic] = derivatives[measurement];
        std::array<double, kBlock> r{};
        r[measurement % 3] = colour;
        r[3] = roughness;
        r[4] = metallic;
        return r;
    }
    double distance(std::size_t texel, std::size_t k) const { // of entry k of its block from the truth
        const std::size_t map = k < 3 ? 0 : k - 2, i = k < 3 ? 3 * texel + k : texel;
        return maps[map].values[i] - truth[first(map) + i];
    }
    // Of half the sum of squares, times the scale.
    std::vector<std::vector<double>> gradients() const {
        std::vector<std::vector<double>> g{std::vector<double>(3 * kTexels), std::vector<double>(kTexels), std::vector<double>(kTexels)};
        for (std::size_t n = 0; n < derivatives.size(); ++n) {
            const std::array<double, kBlock> r = row(n);
            double residual = 0;
            for (std::size_t k = 0; k < kBlock; ++k)
                residual += r[k] * distance(n / 9, k);
            for (std::size_t k = 0; k < kBlock; ++k)
                (k < 3 ? g[0][n / 9 * 3 + k] : g[k - 2][n / 9]) += scale_ * r[k] * residual;
        }
        return g;
    }
    // The true curvature goes into moments and is returned off the diagonals.
    CrossCurvature measure() {
        CrossCurvature cross{std::vector<float>(kTexels * kCross)};
        for (std::size_t n = 0; n < derivatives.size(); ++n) {
            const std::array<double, kBlock> r = row(n);
            for (std::size_t k = 0; k < kBlock; ++k) {
                (k < 3 ? moments[0].second[n / 9 * 3 + k] : moments[k - 2].second[n / 9]) += float(scale_ * r[k] * r[k]);
                for (std::size_t j = 0; j < k; ++j)
                    cross.below[n / 9 * kCross + CrossCurvature::place(k, j)] += float(scale_ * r[k] * r[j]);
            }
        }
        return cross;
    }
    double error(std::size_t map) const {
        double sum = 0;
        for (std::size_t i = 0; i < maps[map].values.size(); ++i)
            sum += std::pow(maps[map].values[i] - truth[first(map) + i], 2) / double(maps[map].values.size());
        return std::sqrt(sum);
    }
    void step(const CrossCurvature& cross, double viewShare = 1, double rate = 0.02) {
        const std::vector<std::vector<double>> g = gradients();
        std::vector<std::vector<double>> none;
        std::vector<TotalVariationBound> known;
        for (std::size_t m = 0; m < maps.size(); ++m) {
            none.emplace_back(g[m].size());
            known.emplace_back(maps[m]);
        }
        std::vector<CoupledMap> coupled;
        for (std::size_t m = 0; m < maps.size(); ++m)
            coupled.push_back({maps[m], moments[m], known[m], g[m], none[m], rate, floors[m]});
        EXPECT_EQ(updateCoupled(coupled, cross, 0, viewShare), 0u);
    }
    void stepApart() {
        const std::vector<std::vector<double>> g = gradients();
        for (std::size_t m = 0; m < maps.size(); ++m) {
            Moments with = moments[m];
            for (float& d : with.second)
                d *= 2; // three groups: (n + 1) / 2
            updateByGaussNewton(0.02, {g[m], std::vector<double>(g[m].size())}, TotalVariationBound(maps[m]), with, maps[m]);
            with.second = moments[m].second;
            moments[m] = with;
        }
    }

    std::vector<Parameter> maps;
    std::vector<Moments> moments;
    std::array<float, 3> floors{};
    std::vector<double> truth; // of all entries, one map after the other
    std::vector<std::array<double, 3>> derivatives; // of measurements: by colour, roughness, metalness

  private:
    double scale_;
};

// Of dim scenes and of bright ones.
TEST(CoupledMaps, FindWhatMapsOnTheirOwnDoNot) {
    for (const double scale : {1e-30, 1.0, 1e15}) {
        Maps together(scale), apart(scale);
        const CrossCurvature cross = together.measure();
        apart.measure();
        const double start = together.error(2);
        for (int k = 0; k < 30; ++k) {
            together.step(cross);
            apart.stepApart();
        }
        for (std::size_t map = 0; map < 3; ++map)
            EXPECT_LT(together.error(map), 0.1 * start) << scale << ", map " << map;
        EXPECT_GT(apart.error(2), 0.6 * start) << scale;
    }
}

// An entry at the end of its range, beyond which its best value lies, is held, and the others find what is best beside it. So it is at a floor above that end.
TEST(CoupledMaps, EntriesAtTheEndOfTheirRangeAreHeld) {
    for (const float floor : {0.f, 0.03f}) {
        Maps maps;
        maps.floors[2] = floor;
        for (std::size_t t = 0; t < kTexels; ++t) {
            maps.truth[Maps::first(2) + t] = floor - 0.1;
            maps.maps[2].values[t] = floor;
        }
        const CrossCurvature cross = maps.measure();
        for (int k = 0; k < 40; ++k)
            maps.step(cross);
        const std::vector<std::vector<double>> g = maps.gradients();
        for (std::size_t t = 0; t < kTexels; ++t) {
            EXPECT_EQ(maps.maps[2].values[t], floor);
            EXPECT_GE(g[2][t], 0) << t;
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(g[0][3 * t + c], 0, 0.01) << t;
            EXPECT_NEAR(g[1][t], 0, 0.01) << t;
        }
    }
}

// A texel's entries are cut by one factor: a part of a step that goes along a valley stays in the valley.
TEST(CoupledMaps, StepsKeepTheirDirection) {
    Maps far, near;
    const CrossCurvature cross = far.measure();
    near.measure();
    far.step(cross);
    near.step(cross, 1, 0.001);
    std::size_t shorter = 0;
    for (std::size_t t = 0; t < kTexels; ++t) {
        double along = 0, a = 0, b = 0;
        for (std::size_t k = 0; k < kBlock; ++k) {
            const std::size_t map = k < 3 ? 0 : k - 2, i = k < 3 ? 3 * t + k : t;
            const double one = far.maps[map].values[i] - 0.5, other = near.maps[map].values[i] - 0.5;
            EXPECT_LE(std::abs(other), 0.01 + 1e-6); // ten rates
            along += one * other;
            a += one * one;
            b += other * other;
        }
        EXPECT_GT(along, 0.9999 * std::sqrt(a * b)) << t;
        shorter += b < 0.5 * a;
    }
    EXPECT_GT(shorter, kTexels / 2);
}

TEST(CoupledMaps, StandAnyGradient) {
    for (const double value : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(), 1e300, -1e300}) {
        Maps maps;
        const CrossCurvature cross = maps.measure();
        std::vector<std::vector<double>> g = maps.gradients(), half = g;
        g[1][7] = half[2][5] = value;
        std::vector<TotalVariationBound> known(maps.maps.begin(), maps.maps.end());
        std::vector<CoupledMap> coupled;
        for (std::size_t m = 0; m < 3; ++m)
            coupled.push_back({maps.maps[m], maps.moments[m], known[m], g[m], half[m], 0.02});
        EXPECT_EQ(updateCoupled(coupled, cross, 0.1, 1), 1u);
        for (const Parameter& map : maps.maps)
            for (const float v : map.values)
                EXPECT_TRUE(v >= 0 && v <= 1);
    }
}

// The curvature of Maps with a prior, some noise and damping. `cross`: times what maps do together.
struct GridOfMaps {
    explicit GridOfMaps(double cross = 1) {
        Maps of;
        std::mt19937 random(3);
        std::uniform_real_distribution<float> uniform(0, 1);
        grid.cross = of.measure();
        for (float& value : grid.cross.below)
            value *= float(cross);
        std::size_t place = 0;
        for (std::size_t m = 0; m < of.maps.size(); ++m) {
            for (float& value : of.maps[m].values)
                value = uniform(random);
            known.emplace_back(of.maps[m]).add(of.maps[m], 5, kPriorCost);
            grid.diagonal.insert(grid.diagonal.end(), of.moments[m].second.begin(), of.moments[m].second.end());
        }
        for (std::size_t m = 0; m < of.maps.size(); ++m) {
            grid.maps.push_back({&known[m], Maps::first(m), place, 0.01 * double(m + 1), 0.02});
            place += of.maps[m].channels;
        }
        for (std::size_t i = 0; i < grid.diagonal.size(); ++i) {
            grid.gradient.push_back(uniform(random) - 0.5f);
            deviation.push_back(1e-3f * uniform(random));
        }
    }
    std::vector<TotalVariationBound> known;
    MapsOnGrid grid;
    std::vector<float> deviation;
};

TEST(BlockCurvature, SolvesWhatItsMatrixSays) {
    const GridOfMaps of;
    MapsOnGrid grid = of.grid;
    const BlockCurvature curvature(grid, of.deviation);
    const std::vector<float> x = curvature.solve(grid.gradient);
    std::vector<float> image(x.size());
    grid.multiply(x, image);
    double off = 0, all = 0, length = 0;
    for (std::size_t m = 0; m < grid.maps.size(); ++m) {
        const std::size_t first = grid.maps[m].entry, count = grid.entries(m);
        const double mean = std::accumulate(grid.diagonal.begin() + std::ptrdiff_t(first), grid.diagonal.begin() + std::ptrdiff_t(first + count), 0.0) / double(count);
        for (std::size_t i = first; i < first + count; ++i) {
            const double added = 1e-3 * mean + grid.maps[m].damping + of.deviation[i] / grid.maps[m].stray, g = grid.gradient[i];
            off += std::pow(image[i] + added * x[i] - g, 2);
            all += g * g;
            std::vector<float> unit(x.size()), column(x.size());
            unit[i] = 1;
            grid.multiply(unit, column);
            length += g * g / (column[i] + added);
        }
    }
    EXPECT_LT(off, 1e-4 * all);
    EXPECT_NEAR(curvature.length(grid.gradient), length, 1e-4 * length);
}

// Noise in what maps do together may be more than the diagonals allow. A step still goes downhill.
TEST(BlockCurvature, IsPositiveWhateverWasMeasured) {
    for (const double cross : {-1.0, 3.0, -50.0, 1e6}) {
        GridOfMaps of(cross);
        const std::vector<float> x = BlockCurvature(of.grid, of.deviation).solve(of.grid.gradient);
        double along = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            ASSERT_TRUE(std::isfinite(x[i])) << cross;
            along += double(x[i]) * of.grid.gradient[i];
        }
        EXPECT_GT(along, 0) << cross;
    }
}

// A material whose maps have those kinds.
Scene makeMaterial(const std::vector<std::pair<SlotKind, std::uint32_t>>& widths) {
    Scene scene;
    Material material;
    for (const auto& [kind, width] : widths) {
        material.parameters[std::size_t(kind)] = std::uint32_t(scene.parameters.size());
        scene.parameters.push_back(makeParameter("wall." + std::string(slotName(kind)), kind, width, 4, slotChannels(kind), kind == SlotKind::Normal ? 0.577f : 0.5f));
    }
    scene.materials.push_back(material);
    return scene;
}

// Entries of CrossCurvature after a step, of the maps that step together.
std::vector<std::size_t> coupledEntries(const std::vector<std::pair<SlotKind, std::uint32_t>>& widths) {
    Scene scene = makeMaterial(widths);
    LinearModel model(scene, 2, 8, 8, 0.1);
    OptimizeConfig config;
    config.optimizer.kind = OptimizerKind::Auto;
    config.targets = makeTargets(2, 8, 8);
    std::vector<std::uint32_t> all(scene.parameters.size());
    std::iota(all.begin(), all.end(), 0u);
    Optimization run(model, scene, config, all);
    run.step();
    std::vector<std::size_t> entries;
    for (const CrossCurvature& cross : run.state().cross)
        entries.push_back(cross.below.size());
    return entries;
}

TEST(CoupledMaps, AreThoseOfOneMaterialWithAsManyTexels) {
    using Sizes = std::vector<std::size_t>;
    EXPECT_EQ(coupledEntries({{SlotKind::BaseColor, 4}, {SlotKind::Roughness, 4}, {SlotKind::Metallic, 4}}), Sizes{16 * 10});
    EXPECT_EQ(coupledEntries({{SlotKind::BaseColor, 4}, {SlotKind::Normal, 4}}), Sizes{16 * 15});
    EXPECT_EQ(coupledEntries({{SlotKind::BaseColor, 8}, {SlotKind::Roughness, 4}, {SlotKind::Metallic, 4}}), Sizes{16 * 1}); // another size
    EXPECT_EQ(coupledEntries({{SlotKind::BaseColor, 4}, {SlotKind::Emission, 4}}), Sizes{});                                 // light
    EXPECT_EQ(coupledEntries({{SlotKind::BaseColor, 4}}), Sizes{});
}

// The loss after so many steps over that of the first, of two maps that each pixel answers to in its own way: of one material, or of none.
double lossOfTwo(bool together, std::size_t views, std::uint32_t steps) {
    Scene scene;
    for (const SlotKind kind : {SlotKind::BaseColor, SlotKind::Specular})
        scene.parameters.push_back(makeParameter("wall." + std::string(slotName(kind)), kind, 4, 4, 3, 0.5f));
    if (together) {
        Material& material = scene.materials.emplace_back();
        material.parameters[std::size_t(SlotKind::BaseColor)] = 0;
        material.parameters[std::size_t(SlotKind::Specular)] = 1;
    }
    const Scene truth = truthOf(scene, 5, 0.8f);
    LinearModel model(scene, views, 16, 16, 0), target(truth, views, 16, 16, 0);
    OptimizeConfig config;
    config.optimizer.kind = OptimizerKind::Auto;
    config.targets.resize(views);
    for (std::size_t view = 0; view < views; ++view)
        config.targets[view].image = target.picture(view, 1, {}, false);
    Optimization run(model, scene, config, {0, 1});
    const double before = run.step().loss;
    while (run.state().step < steps)
        run.step();
    return run.state().history.back().loss / before;
}

TEST(CoupledMaps, ComeNearerInAsManySteps) {
    const double together = lossOfTwo(true, 1, 10), apart = lossOfTwo(false, 1, 10), turns = lossOfTwo(true, 6, 80);
    std::cout << "loss after 10 steps: " << together << " together, " << apart << " apart; of views in turns after 80: " << turns << "\n";
    EXPECT_LT(together, 0.1 * apart);
    EXPECT_LT(turns, 1e-8); // nothing is noise
}

} // namespace
} // namespace cmpg::test

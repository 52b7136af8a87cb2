// The guide command: its figures against sums made here, its pictures, its exit codes.
#include "app/commands.h"
#include "guiding/field/density_map.h"
#include "command_line.h"
#include "guiding/guide_file.h"
#include "guiding/samples.h"
#include "library/guide_statistics.h"
#include "scene/image.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <sstream>

namespace cmpg {
namespace {

using test::runProgram;

const glm::vec3 kLower(-1, -2, 0.5f), kUpper(1, 2, 1.5f);

SdTree grown() {
    SdTreeConfig config;
    config.cellRecords = 2000;
    SdTree tree(kLower, kUpper, config);
    for (std::uint32_t i = 0; i < 3; ++i)
        tree.update(place(tree, randomSamples(kLower, kUpper, 20'000, i)));
    return tree;
}

// One cell whose quadtree has a single path of `depth` levels, everything in the last node's quadrant 1: x high, y low.
GuideCell peaked(std::uint32_t depth) {
    GuideCell cell;
    cell.records = 10;
    cell.nodes.resize(depth);
    for (std::uint32_t i = 0; i < depth; ++i) {
        cell.nodes[i].mass[1] = {20, 5, 0};
        cell.nodes[i].child[1] = i + 1 < depth ? i + 1 : 0;
    }
    return cell;
}

TEST(DensityMap, HasMeanOneWhateverItsResolution) {
    const SdTree tree = grown();
    for (const GuideCell& cell : tree.cells())
        for (const int edge : {2, 16, 256}) {
            const Image map = densityMap(cell, {1, 0.3, 2}, edge);
            double sum = 0;
            for (const float v : map.values)
                sum += double(v);
            EXPECT_NEAR(sum / (edge * edge), 1, 1e-6); // rounding of floats
        }
}

TEST(DensityMap, PutsMassWhereItIs) {
    for (const std::uint32_t depth : {1u, 3u, 10u}) {
        const GuideCell cell = peaked(depth);
        const Image map = densityMap(cell, {1, 1, 1}, 16);
        const int finest = std::min(4, int(depth)); // pixels are four levels down
        const int width = 16 >> finest;
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 16; ++x) {
                const bool inside = x >= 16 - width && y >= 16 - width; // azimuth just below 2 pi, z near -1: bottom right
                EXPECT_EQ(map.at(x, y)[0], inside ? float(std::pow(4, finest)) : 0.f) << depth << ": " << x << ", " << y;
            }
    }
    const Image nothing = densityMap(peaked(2), {0, 0, 1}, 8);
    EXPECT_EQ(*std::max_element(nothing.values.begin(), nothing.values.end()), 0);
}

TEST(GuideFigures, AgreeWithTheTree) {
    SdTree tree = grown();
    // Cells without derivatives, and one without any record.
    for (std::size_t i = 0; i < 5; ++i) {
        GuideCell& cell = tree.cells()[i];
        for (QuadNode& node : cell.nodes)
            for (GuideMass& m : node.mass)
                m = i == 0 ? GuideMass{} : GuideMass{m.primal, 0, 0};
        cell.records *= i == 0 ? 0 : 1;
    }
    const std::vector<GuideCellFigures> cells = cellFigures(tree);
    const GuideFigures f = figuresOf(tree, cells);
    const TreeTotals sums = totals(tree);
    const double count = double(tree.cells().size());
    EXPECT_EQ(f.cells, tree.cells().size());
    EXPECT_EQ(f.nodes, tree.nodes());
    EXPECT_NEAR(f.records, sums.records, 1e-9 * sums.records);
    EXPECT_NEAR(f.mass[0], sums.mass.primal, 1e-9 * sums.mass.primal);
    EXPECT_NEAR(f.mass[2], sums.mass.minus, 1e-9 * sums.mass.minus);
    EXPECT_EQ(f.withoutRecords, 1 / count);
    EXPECT_EQ(f.withoutDerivative, 5 / count);
    double volume = 0, halvings = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const auto vector = [](const std::array<double, 3>& v) { return glm::dvec3(v[0], v[1], v[2]); };
        const glm::dvec3 lower = vector(cells[i].lower), upper = vector(cells[i].upper), size = upper - lower;
        volume += size.x * size.y * size.z;
        halvings += std::exp2(-double(cells[i].depth));
        EXPECT_EQ(tree.cellAt((lower + upper) * 0.5), i);
        EXPECT_LE(cells[i].records, cells[f.mostRecords].records);
        EXPECT_LE(cells[i].depth, f.spatialDepth);
        EXPECT_LE(cells[i].quadDepth, f.quadDepth);
    }
    EXPECT_EQ(volume, 8); // 2 x 4 x 1, halved without rounding
    EXPECT_EQ(halvings, 1);
    EXPECT_EQ(validateDensities(tree), "");
}

TEST(GuideFigures, DepthsCountLevels) {
    SdTree tree(kLower, kUpper, {});
    const GuideFigures scout = figuresOf(tree, cellFigures(tree));
    EXPECT_EQ(scout.spatialDepth, SdTree::kScoutDepth);
    EXPECT_EQ(scout.meanSpatialDepth, SdTree::kScoutDepth);
    EXPECT_EQ(scout.quadDepth, SdTree::kScoutQuadDepth);
    EXPECT_EQ(scout.meanQuadDepth, SdTree::kScoutQuadDepth);
    EXPECT_EQ(scout.withoutRecords, 1);
}

TEST(GuideFigures, DensitiesThatFloatsLoseAreFound) {
    SdTree tree = grown();
    for (QuadNode& node : tree.cells()[1].nodes)
        for (GuideMass& m : node.mass)
            m.minus *= 1e-44; // denormal floats
    EXPECT_NE(validateDensities(tree).find("cell 1 "), std::string::npos);
}

Options guideOptions(const std::string& file) {
    Options o;
    o.command = Command::Guide;
    o.input = file;
    o.json = true; // keep the test's output clean
    return o;
}

TEST(Guide, PrintsDrawsAndChecks) {
    const test::TemporaryFolder folder;
    const SdTree tree = grown();
    GuideContext context;
    context.geometry = 0xabc;
    context.parameters = {"painting.baseColor"};
    context.figures[Sampling::Conditional] = {0.5, 7, 8};
    context.rouletteFigures[Sampling::Primal] = {0.25, 3, 8};
    const std::string file = folder / "a.guide";
    saveGuide(file, tree, context);

    const auto text = runProgram({"--headless", "guide", file, "--validate", "-o", folder / "maps"});
    EXPECT_EQ(text.code, 0) << text.err;
    for (const std::string& part : {std::to_string(tree.cells().size()), std::string("painting.baseColor"), std::string("0000000000000abc"),
                                    std::string("conditional"), std::string("roulette"), std::string("valid:       yes")})
        EXPECT_NE(text.out.find(part), std::string::npos) << part << "\n" << text.out;
    const GuideFigures f = figuresOf(tree, cellFigures(tree));
    EXPECT_TRUE(std::filesystem::exists(folder / ("maps/cell" + std::to_string(f.mostRecords) + ".png")));

    const auto json = nlohmann::json::parse(runProgram({"guide", file, "--json"}).out).at("guide");
    EXPECT_EQ(json.at("cells"), tree.cells().size());
    EXPECT_EQ(json.at("nodes"), tree.nodes());
    EXPECT_EQ(json.at("mass").at("plus"), f.mass[1]);
    EXPECT_EQ(json.at("figures").at("conditional").at("rays"), 7);
    EXPECT_FALSE(json.contains("valid")); // not asked

    std::istringstream csv(runProgram({"guide", file, "--csv"}).out);
    std::vector<std::string> lines;
    for (std::string line; std::getline(csv, line);)
        lines.push_back(line);
    ASSERT_EQ(lines.size(), tree.cells().size() + 1);
    const auto columns = [](const std::string& line) { return std::count(line.begin(), line.end(), ','); };
    for (std::size_t i = 1; i < lines.size(); ++i) {
        EXPECT_EQ(columns(lines[i]), columns(lines[0]));
        EXPECT_EQ(lines[i].rfind(std::to_string(i - 1) + ",", 0), 0u);
    }
}

TEST(Guide, PicturesShowTheChosenMixture) {
    const test::TemporaryFolder folder;
    const SdTree tree = grown();
    const std::string file = folder / "a.guide";
    saveGuide(file, tree, {});
    const auto draw = [&](const std::string& weights) {
        Options o = guideOptions(file);
        o.output = folder.path();
        o.cell = 0;
        o.weights = weights;
        Report report(o);
        EXPECT_EQ(runGuide(o, report), ExitStatus::Done);
        return readImage(folder / "cell0.png").image;
    };
    const Image light = draw("1,0"), derivative = draw("0,1e-3");
    EXPECT_NE(light.values, derivative.values);
    // Light alone: the last panel has the first one's colours. Panels are 282 pixels apart.
    for (int y = 50; y < 306; y += 5)
        for (int x = 26; x < 282; x += 5)
            for (int c = 0; c < 3; ++c)
                ASSERT_EQ(light.at(x, y)[c], light.at(x + 3 * 282, y)[c]) << x << ", " << y;
}

TEST(Guide, ExitCodes) {
    const test::TemporaryFolder folder;
    const std::string file = folder / "a.guide";
    saveGuide(file, grown(), {});
    std::string damaged = test::readText(file);
    damaged[damaged.size() / 2] ^= 4;
    test::writeText(folder / "damaged.guide", damaged);
    const struct {
        std::vector<std::string> arguments;
        int code;
        std::string says;
    } cases[] = {
        {{"guide"}, 2, "needs a guide"},
        {{"guide", file, "--cell", "4000000000"}, 2, "no cell 4000000000"},
        {{"guide", file, "--cell", "-1"}, 2, "whole number"},
        {{"guide", file, "--weights", "1"}, 2, "--weights"},
        {{"guide", file, "--weights", "0,0"}, 2, "--weights"},
        {{"guide", file, "--weights", "1,2,"}, 2, "--weights"},
        {{"guide", file, "--weights", "nan,1"}, 2, "--weights"},
        {{"guide", folder / "missing.guide"}, 3, "missing.guide"},
        {{"guide", folder / "missing.guide", "--validate"}, 3, "missing.guide"},
        {{"guide", folder / "damaged.guide"}, 3, "checksum"},
        {{"guide", folder / "damaged.guide", "--validate"}, 1, "checksum"},
        {{"guide", file, "-o", "/nonexistent/maps"}, 6, "/nonexistent"},
    };
    for (const auto& c : cases) {
        const auto result = runProgram(c.arguments);
        EXPECT_EQ(result.code, c.code) << c.says << "\n" << result.err;
        EXPECT_NE(result.err.find(c.says), std::string::npos) << c.says << "\n" << result.err;
        EXPECT_EQ(result.out, "");
    }
}

} // namespace
} // namespace cmpg

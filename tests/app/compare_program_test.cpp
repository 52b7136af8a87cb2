// The compare command on a small image of the box: files, columns, and a page that needs nothing but itself.
#include "command_line.h"
#include "scene/image.h"

#include <gtest/gtest.h>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

namespace cmpg {
namespace {

using test::readText;
using test::runProgram;

const std::string kBox = CMPG_SOURCE_DIR "/scenes/box/scene.gltf"; // painting.baseColor has 64x64 texels

std::vector<std::vector<std::string>> readCsv(const std::string& file) {
    std::vector<std::vector<std::string>> rows;
    std::istringstream in(readText(file));
    for (std::string line; std::getline(in, line);) {
        rows.emplace_back();
        std::istringstream fields(line + ",");
        for (std::string field; std::getline(fields, field, ',');)
            rows.back().push_back(field);
    }
    return rows;
}

// Every element that is opened is closed, in order; attributes are quoted.
void expectWellFormed(const std::string& html) {
    std::vector<std::string> open;
    for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at)) {
        const std::size_t end = html.find('>', at);
        ASSERT_NE(end, std::string::npos);
        const std::string tag = html.substr(at + 1, end - at - 1);
        at = end;
        if (tag[0] == '!')
            continue;
        EXPECT_EQ(std::count(tag.begin(), tag.end(), '"') % 2, 0) << tag.substr(0, 80);
        const std::string name = tag.substr(0, tag.find_first_of(" /", 1));
        if (tag[0] == '/') {
            ASSERT_FALSE(open.empty()) << tag;
            ASSERT_EQ("/" + open.back(), tag);
            open.pop_back();
        } else if (tag.back() != '/' && name != "meta" && name != "img") {
            open.push_back(name);
        }
    }
    EXPECT_TRUE(open.empty());
}

void expectSelfContained(const std::string& html) {
    for (const char* outside : {"http:", "https:", "<script", "<link", "@import", "url("})
        EXPECT_EQ(html.find(outside), std::string::npos) << outside;
    for (std::size_t at = html.find("src="); at != std::string::npos; at = html.find("src=", at + 1))
        EXPECT_TRUE(html.compare(at, 27, "src=\"data:image/png;base64,") == 0 || html.compare(at, 31, "src=\"data:image/svg+xml;base64,") == 0)
            << html.substr(at, 40);
}

nlohmann::json compare(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"compare", kBox});
    for (const char* a : {"--headless", "--json", "--max-depth", "4", "--methods", "plain,bsdf+pixels"})
        arguments.emplace_back(a);
    const auto result = runProgram(arguments);
    EXPECT_EQ(result.code, 0) << result.err;
    return result.code == 0 ? nlohmann::json::parse(result.out) : nlohmann::json::object();
}

TEST(CompareProgram, WritesFilesOfBothDerivatives) {
    const test::TemporaryFolder folder;
    writeExr(folder / "adjoint.exr", Image(64, 64, 3, 1e-3f));
    const auto json = compare({"--param", "painting.baseColor", "--param", "white.baseColor", "--mode", "forward,reverse", "--adjoint",
                               folder / "adjoint.exr", "--spp", "2", "--seeds", "6", "--reference-time", "0.5", "-o", folder / "out"});
    ASSERT_EQ(json.at("table").size(), 6u); // two methods and a reference, twice
    EXPECT_EQ(json.at("width"), 64);
    for (const auto& [name, path] : json.at("outputs").items())
        EXPECT_TRUE(std::filesystem::exists(path.get<std::string>())) << name;

    const auto rows = readCsv(folder / "out/results.csv");
    ASSERT_EQ(rows.size(), 5u);
    std::map<std::string, std::size_t> column;
    for (std::size_t i = 0; i < rows[0].size(); ++i)
        column[rows[0][i]] = i;
    for (std::size_t r = 1; r < rows.size(); ++r) {
        ASSERT_EQ(rows[r].size(), rows[0].size());
        const auto number = [&](const char* name) { return std::stod(rows[r].at(column.at(name))); };
        EXPECT_EQ(number("passes"), 6);
        EXPECT_NEAR(number("spp"), 12, 0.5); // pixel sampling rounds at random
        EXPECT_TRUE(std::isfinite(number("mse"))); // without the reference's own error, hence below 0 at times where that is large
        EXPECT_GT(number("relative_variance"), 0);
        EXPECT_NEAR(number("efficiency") * number("relative_variance") * number("seconds") / number("passes"), 1, 1e-6);
        EXPECT_LT(std::abs(number("bias")), 5 * number("bias_95") + 0.05);
    }
    EXPECT_EQ(rows[1][column["mode"]] + rows[1][column["method"]], "forwardplain");
    EXPECT_EQ(rows[4][column["mode"]] + rows[4][column["method"]], "reversebsdf+pixels");
    EXPECT_EQ(std::stod(rows[1][column["ratio"]]), 1);

    const Image image = readImage(folder / "out/forward/plain.exr").image;
    EXPECT_EQ(image.width, 64);
    EXPECT_EQ(readImage(folder / "out/reverse/bsdf+pixels.painting.baseColor.exr").image.height, 64);
    EXPECT_EQ(readText(folder / "out/error_over_time.csv").rfind("mode,method,passes,seconds,mse\n", 0), 0u);
    const std::string html = readText(folder / "out/report.html");
    expectWellFormed(html);
    expectSelfContained(html);
    for (const char* part : {"Derivative image", "Gradient", "bsdf+pixels", "white.baseColor", "image/svg+xml", "has learned once"})
        EXPECT_NE(html.find(part), std::string::npos) << part;
}

TEST(CompareProgram, ComparesOptimisations) {
    const test::TemporaryFolder folder;
    const auto target = runProgram({"render", kBox, "-o", folder / "target.exr", "--width", "64", "--height", "64", "--spp", "16", "--seed", "3",
                                    "--max-depth", "4"});
    ASSERT_EQ(target.code, 0) << target.err;
    const auto json = compare({"--param", "painting.baseColor", "--mode", "optimize", "--target", folder / "target.exr", "--set",
                               "painting.baseColor=0.5", "--steps", "12", "--rate", "0.05", "--spp", "8", "-o", folder / "out"});
    ASSERT_EQ(json.at("table").size(), 2u);
    for (const auto& row : json.at("table")) {
        EXPECT_EQ(row.at("steps"), 12);
        EXPECT_LT(row.at("mse"), 0.7 * row.at("initial_mse").get<double>()) << row; // against the scene's own values
        EXPECT_GT(row.at("seconds"), 0);
    }
    EXPECT_EQ(readCsv(folder / "out/error_over_time.csv").size(), 1u + 2 * 13); // the start and every step
    EXPECT_EQ(readImage(folder / "out/plain.exr").image.width, 64);
    const std::string html = readText(folder / "out/report.html");
    expectWellFormed(html);
    expectSelfContained(html);
}

// Two names of one method do the same in each repetition: at the latest with the last step one is as good as the other.
TEST(CompareProgram, TellsOfTheStepsAndRepetitionsThatWere) {
    const test::TemporaryFolder folder;
    const auto target = runProgram({"render", kBox, "-o", folder / "target.exr", "--width", "16", "--height", "16", "--spp", "64", "--seed", "3",
                                    "--max-depth", "3"});
    ASSERT_EQ(target.code, 0) << target.err;
    const auto result = runProgram({"compare", kBox, "--headless", "--param", "white.baseColor", "--mode", "forward,optimize", "--target",
                                    folder / "target.exr", "--set", "white.baseColor=0.5", "--methods", "plain,bsdf", "--quality", "preview",
                                    "--max-depth", "3", "--spp-difference", "6", "--steps", "9", "--stop-after", "3", "--seeds", "4", "-o",
                                    folder / "out"});
    ASSERT_EQ(result.code, 0) << result.err;
    const std::string html = readText(folder / "out/report.html");
    expectWellFormed(html);
    for (const char* part : {": 3 steps for each method; the first step renders 4 samples per pixel, further ones bring that image up to date with at "
                             "most 6, and each differentiates 1.",
                             "<span class=\"how\">4 of 4 runs</span>"})
        EXPECT_NE(html.find(part), std::string::npos) << part;
    EXPECT_EQ(html.find("Gradient descent"), std::string::npos);
}

// Where all light comes from a point, a method without light sampling finds nothing.
TEST(CompareProgram, IsNotMisledByWhatFindsNothing) {
    const test::TemporaryFolder folder;
    test::writeText(folder / "scene.xml",
                    "<scene version=\"3.0.0\"><sensor type=\"perspective\"><transform name=\"to_world\"><lookat origin=\"0,0,4\" target=\"0,0,0\" "
                    "up=\"0,1,0\"/></transform></sensor><emitter type=\"point\"><point name=\"position\" value=\"0,1,1\"/></emitter>"
                    "<shape type=\"rectangle\"><bsdf type=\"diffuse\" id=\"wall\"/></shape></scene>");
    const auto result = runProgram({"compare", folder / "scene.xml", "--headless", "--json", "--param", "wall.reflectance", "--mode", "forward", "--methods",
                                    "plain+nonee,plain", "--width", "16", "--height", "16", "--spp", "4", "--seeds", "8", "-o", folder / "out"});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.err.find("(--no-nee) 1 punctual light"), std::string::npos) << result.err;
    const auto json = nlohmann::json::parse(result.out);
    EXPECT_EQ(json.at("table").at(2).at("made_by"), "plain");
    EXPECT_TRUE(json.at("table").at(0).at("biased"));
    EXPECT_GT(json.at("table").at(1).at("efficiency"), 0);
    EXPECT_EQ(readText(folder / "out/report.html").find("reaches the error"), std::string::npos);
    const auto image = runProgram({"render", folder / "scene.xml", "--headless", "--no-nee", "--width", "8", "--spp", "1", "-o", folder / "dark.exr"});
    EXPECT_NE(image.err.find("(--no-nee) 1 punctual light"), std::string::npos) << image.err;
}

// The first view's target is the picture of the start, from which there is nothing to learn: what is found comes from the second.
TEST(CompareProgram, OptimisesFromSeveralViews) {
    const test::TemporaryFolder folder;
    const auto render = [&](const char* camera, const char* file, std::vector<std::string> more) {
        std::vector<std::string> arguments{"render", kBox, "-o", folder / file, "--camera", camera, "--spp", "64", "--seed", "3", "--max-depth", "4"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const auto result = runProgram(arguments);
        ASSERT_EQ(result.code, 0) << result.err;
    };
    render("front", "start.exr", {"--width", "32", "--height", "32", "--set", "painting.baseColor=0.5"});
    render("corner", "truth.exr", {"--width", "64", "--height", "48"});
    const auto json = compare({"--param", "painting.baseColor", "--mode", "optimize", "--target", "front=" + (folder / "start.exr"), "--target",
                               "corner=" + (folder / "truth.exr"), "--set", "painting.baseColor=0.5", "--steps", "12", "--rate", "0.05", "--spp",
                               "8", "-o", folder / "out"});
    ASSERT_EQ(json.at("table").size(), 2u);
    for (const auto& row : json.at("table"))
        EXPECT_LT(row.at("mse"), 0.8 * row.at("initial_mse").get<double>()) << row;
    EXPECT_NE(readText(folder / "out/report.html").find("a further target"), std::string::npos);
}

TEST(CompareProgram, EqualTimeAndRepeats) {
    const test::TemporaryFolder folder;
    writeExr(folder / "adjoint.exr", Image(16, 16, 3, 1e-3f));
    const auto json = compare({"--param", "painting.baseColor", "--adjoint", folder / "adjoint.exr", "--spp", "1", "--time", "0.3", "-o",
                               folder / "out"});
    for (const auto& row : json.at("table"))
        if (row.at("method") != "reference") {
            EXPECT_GE(row.at("seconds"), 0.3);
        }
    EXPECT_TRUE(std::filesystem::exists(folder / "out/run.json"));
    // Its options reproduce the run, in another folder.
    const auto again = runProgram({"--config", folder / "out/run.json", "--headless", "-o", folder / "again"});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_EQ(readText(folder / "again/run.json"), readText(folder / "out/run.json"));
}

TEST(CompareProgram, RefusesWhatItCannotCompare) {
    const test::TemporaryFolder folder;
    const std::string out = folder / "out";
    writeExr(folder / "image.exr", Image(16, 16, 3, 1));
    const std::vector<std::string> start = {"compare", kBox, "--headless"};
    const std::vector<std::pair<std::vector<std::string>, int>> cases = {
        {{"--param", "painting.baseColor", "-o", out}, 2}, // neither adjoint nor target
        {{"--param", "painting.baseColor", "--mode", "optimize", "--adjoint", folder / "image.exr", "-o", out}, 2},
        {{"--param", "painting.baseColor", "--mode", "reverse", "--target", folder / "image.exr", "--target", folder / "image.exr", "-o", out}, 2},
        {{"--mode", "forward", "-o", out}, 2},
        {{"--param", "painting.baseColor", "--mode", "forward"}, 2},
        {{"--param", "painting.baseColor", "--mode", "forward", "--methods", "magic", "-o", out}, 2},
        {{"--param", "painting.baseColor", "--mode", "forward", "--time", "-1", "-o", out}, 2},
        {{"--param", "painting.baseColor", "--mode", "forward", "--seeds", "1", "-o", out}, 2},
        {{"--param", "painting.baseColor", "--mode", "forward", "--reference", folder / "image.exr", "-o", out}, 3}, // 256 wide by default
        {{"--param", "painting.baseColor", "--mode", "forward", "-o", folder / "no/such/place"}, 6},
    };
    for (const auto& [arguments, code] : cases) {
        std::vector<std::string> all = start;
        all.insert(all.end(), arguments.begin(), arguments.end());
        const auto result = runProgram(all);
        EXPECT_EQ(result.code, code) << arguments[2] << " " << arguments[3] << "\n" << result.err;
        EXPECT_FALSE(std::filesystem::exists(out));
    }
}

} // namespace
} // namespace cmpg

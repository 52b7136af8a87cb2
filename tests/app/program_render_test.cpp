// The rendering commands as a user runs them, on a small bundled scene: what they write and print.
#include "command_line.h"
#include "scene/image.h"

#include <algorithm>
#include <csignal>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace cmpg {
namespace {

using test::readText;
using test::runProgram;
namespace fs = std::filesystem;

const std::string kBox = CMPG_SOURCE_DIR "/scenes/box/scene.gltf"; // painting.baseColor has 64x64 texels
const std::string kPainting = "painting.baseColor";

// Byte for byte; an expectation of equality would print the files.
bool sameBytes(const std::string& a, const std::string& b) {
    return a == b;
}

// Runs with a small image and few samples; expects success.
nlohmann::json run(std::vector<std::string> arguments) {
    for (const char* a : {"--headless", "--json", "--width", "32", "--height", "24", "--max-depth", "4"})
        arguments.push_back(a);
    const auto result = runProgram(arguments);
    EXPECT_EQ(result.code, 0) << arguments[0] << "\n" << result.err;
    return result.code == 0 ? nlohmann::json::parse(result.out) : nlohmann::json::object();
}

TEST(ProgramRender, ReportsWhatItDid) {
    const test::TemporaryFolder folder;
    const auto json = run({"render", kBox, "-o", folder / "a.exr", "--layers", folder / "l.exr", "--spp", "4", "--memory", "64", "--kernel-times"});
    EXPECT_EQ(json.at("command"), "render");
    EXPECT_EQ(json.at("width"), 32);
    EXPECT_EQ(json.at("height"), 24);
    EXPECT_EQ(json.at("spp"), 4);
    EXPECT_EQ(json.at("paths"), 32 * 24 * 4);
    EXPECT_GE(json.at("rays"), json.at("paths"));
    EXPECT_EQ(json.at("memory").at("budget_bytes"), 64 << 20);
    EXPECT_GT(json.at("memory").at("device_peak_bytes"), 0);
    EXPECT_FALSE(json.at("device").get<std::string>().empty());
    EXPECT_GT(json.at("seconds").at("primal"), 0);
    EXPECT_EQ(json.at("seconds").at("gradient"), 0);
    double kernelSeconds = 0;
    for (const auto& [name, time] : json.at("kernels").items()) {
        EXPECT_GT(time.at("calls"), 0) << name;
        kernelSeconds += time.at("seconds").get<double>();
    }
    EXPECT_GT(kernelSeconds, 0);
    EXPECT_LE(kernelSeconds, json.at("seconds").at("total").get<double>());
    for (const auto& [name, path] : json.at("outputs").items())
        EXPECT_TRUE(fs::exists(path.get<std::string>())) << name;
    const Image image = readImage(folder / "a.exr").image;
    EXPECT_EQ(image.width, 32);
    EXPECT_EQ(image.height, 24);
}

// The same scene, its filter in the file or on the command line.
TEST(ProgramRender, FiltersAreThoseOfMitsubaFiles) {
    const test::TemporaryFolder folder;
    const auto scene = [&](const std::string& name, const std::string& filter) {
        test::writeText(folder / name, "<scene version=\"3.0.0\"><shape type=\"rectangle\"><bsdf type=\"diffuse\" id=\"wall\"/><emitter type=\"area\">"
                                       "<rgb name=\"radiance\" value=\"1 2 3\"/></emitter></shape><sensor type=\"perspective\"><transform name=\"to_world\">"
                                       "<lookat origin=\"0.4, 0.3, 4\" target=\"0, 0, 0\" up=\"0, 1, 0\"/></transform><film type=\"hdrfilm\">" + filter +
                                       "</film></sensor></scene>");
        return folder / name;
    };
    const std::string tent = scene("tent.xml", "<rfilter type=\"tent\"><float name=\"radius\" value=\"1.5\"/></rfilter>"), gaussian = scene("gaussian.xml", ""),
                      box = scene("box.xml", "<rfilter type=\"box\"/>");
    const auto bytes = [&](const std::string& command, const std::string& file, const std::string& filter) {
        std::vector<std::string> arguments = {command, file, "-o", folder / "a.exr", "--spp", "4"};
        if (!filter.empty())
            arguments.insert(arguments.end(), {"--filter", filter});
        if (command == "gradient")
            arguments.insert(arguments.end(), {"--param", "*.radiance"});
        run(arguments);
        return readText(folder / "a.exr");
    };
    for (const std::string command : {"render", "gradient"}) {
        EXPECT_TRUE(sameBytes(bytes(command, box, "tent:1.5"), bytes(command, tent, ""))) << command;
        EXPECT_TRUE(sameBytes(bytes(command, tent, "gaussian"), bytes(command, gaussian, ""))) << command;
        EXPECT_TRUE(sameBytes(bytes(command, gaussian, "box"), bytes(command, box, ""))) << command;
        EXPECT_FALSE(sameBytes(bytes(command, tent, ""), bytes(command, box, ""))) << command;
    }
}

TEST(ProgramRender, RunJsonReproducesTheRun) {
    const test::TemporaryFolder folder;
    run({"render", kBox, "-o", folder / "a.exr", "--spp", "2", "--seed", "7", "--camera", "corner", "--set", kPainting + "=0.2,0.3,0.4"});
    const std::string config = folder / "run.json", first = readText(folder / "a.exr");
    const auto json = nlohmann::json::parse(readText(config));
    EXPECT_EQ(json.at("width"), 32);
    EXPECT_EQ(json.at("camera"), "corner");
    EXPECT_EQ(json.at("max-depth"), 4);
    fs::create_directory(folder / "again");
    const auto again = runProgram({"--config", config, "--quiet", "-o", folder / "again/b.exr"});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_EQ(again.out, "");
    EXPECT_TRUE(sameBytes(readText(folder / "again/b.exr"), first));
    EXPECT_TRUE(sameBytes(readText(folder / "again/run.json"), readText(config)));
    EXPECT_EQ(runProgram({"--config", config, "--seed", "8", "-o", folder / "again/c.exr"}).code, 0);
    EXPECT_FALSE(sameBytes(readText(folder / "again/c.exr"), first));
}

TEST(ProgramRender, SetTakesNumbersAndFilesAlike) {
    const test::TemporaryFolder folder;
    writeExr(folder / "v.exr", Image(64, 64, 3, 0.25f));
    run({"render", kBox, "-o", folder / "a.exr", "--spp", "2", "--set", kPainting + "=0.25"});
    run({"render", kBox, "-o", folder / "b.exr", "--spp", "2", "--set", "paint*.baseColor=" + folder / "v.exr"});
    run({"render", kBox, "-o", folder / "c.exr", "--spp", "2"});
    EXPECT_TRUE(sameBytes(readText(folder / "a.exr"), readText(folder / "b.exr")));
    EXPECT_FALSE(sameBytes(readText(folder / "a.exr"), readText(folder / "c.exr")));
    writeExr(folder / "small.exr", Image(8, 8, 3, 0.25f));
    EXPECT_EQ(runProgram({"render", kBox, "-o", folder / "d.exr", "--set", kPainting + "=" + folder / "small.exr"}).code, 3);
    EXPECT_EQ(runProgram({"render", kBox, "-o", folder / "d.exr", "--set", kPainting + "=1.5"}).code, 2);
}

TEST(ProgramGradient, DirectionsAreLinear) {
    const test::TemporaryFolder folder;
    const std::vector<std::string> common = {"gradient", kBox, "--param", kPainting, "--spp", "4", "--set", kPainting + "=0.5", "-o"};
    const auto gradient = [&](const std::string& direction) {
        std::vector<std::string> arguments = common;
        arguments.insert(arguments.end(), {folder / "g.exr", "--direction", direction});
        const auto json = run(arguments);
        EXPECT_EQ(json.at("seconds").at("primal"), 0); // forward mode runs no primal pass
        return readImage(folder / "g.exr").image;
    };
    writeExr(folder / "v.exr", Image(64, 64, 3, -2.0f));
    const Image one = gradient("one"), self = gradient("self"), file = gradient(folder / "v.exr");
    double largest = 0;
    for (const float v : one.values)
        largest = std::max(largest, std::abs(double(v)));
    ASSERT_GT(largest, 0);
    double selfError = 0, fileError = 0;
    for (std::size_t i = 0; i < one.values.size(); ++i) {
        selfError = std::max(selfError, std::abs(double(self.values[i] - 0.5f * one.values[i]))); // every value is 0.5
        fileError = std::max(fileError, std::abs(double(file.values[i] + 2 * one.values[i])));
    }
    EXPECT_LE(selfError, 1e-5 * largest); // the same random numbers, so only rounding
    EXPECT_LE(fileError, 1e-5 * largest);
}

// Halves for the two signs add up to the whole, also where nothing is guided.
TEST(ProgramGradient, PositivizedIsTheSame) {
    const test::TemporaryFolder folder;
    const std::vector<std::string> common = {"gradient", kBox, "--param", kPainting, "--direction", "self", "--spp", "64", "--sampling", "bsdf", "-o"};
    double sums[2]{};
    for (const bool positivized : {false, true}) {
        std::vector<std::string> arguments = common;
        arguments.push_back(folder / "a.exr");
        if (positivized)
            arguments.emplace_back("--positivize");
        run(arguments);
        for (const float v : readImage(folder / "a.exr").image.values)
            sums[positivized] += double(v);
    }
    EXPECT_NEAR(sums[1] / sums[0], 1, 0.1); // the noise of 64 samples is 2 %; each half taken for the whole would give 2
}

TEST(ProgramGradient, ReverseKeepsTheShapeOfEachParameter) {
    const test::TemporaryFolder folder;
    run({"render", kBox, "-o", folder / "t.exr", "--spp", "4"});
    const auto json = run({"gradient", kBox, "--param", kPainting, "--param", "white.b*", "--param", "white.rough*", "--target",
                           folder / "t.exr", "--loss", "l1", "--set", kPainting + "=0.5", "--spp", "4", "-o", folder / "g"});
    EXPECT_EQ(json.at("loss").size(), 1u);
    EXPECT_GT(json.at("loss")[0], 0);
    EXPECT_GT(json.at("seconds").at("primal"), 0);
    const Image painting = readImage(folder / "g/painting.baseColor.exr").image, white = readImage(folder / "g/white.baseColor.exr").image;
    EXPECT_EQ(painting.width, 64);
    EXPECT_EQ(painting.height, 64);
    EXPECT_EQ(white.width, 1);
    const Image roughness = readImage(folder / "g/white.roughness.exr").image; // a scalar: three equal channels
    ASSERT_EQ(roughness.channels, 3);
    EXPECT_EQ(roughness.values[0], roughness.values[1]);
    EXPECT_EQ(roughness.values[0], roughness.values[2]);
    run({"gradient", kBox, "--param", kPainting, "--adjoint", folder / "t.exr", "--spp", "4", "-o", folder / "one.exr"});
    EXPECT_EQ(readImage(folder / "one.exr").image.width, 64);
    EXPECT_EQ(
        runProgram({"gradient", kBox, "--param", kPainting, "--adjoint", folder / "t.exr", "--width", "33", "-o", folder / "x.exr"}).code,
        3);
    EXPECT_EQ(runProgram({"gradient", kBox, "--param", kPainting, "--adjoint", kBox, "-o", folder / "x.exr"}).code, 3);
}

TEST(ProgramGradient, SaysThatNothingWasLearnedToDrawBy) {
    const test::TemporaryFolder folder;
    const auto result = runProgram({"render", kBox, "-o", folder / "a.exr", "--width", "16", "--spp", "1", "--sampling", "primal", "--json"});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.err.find("add --train N or --load-guide FILE"), std::string::npos) << result.err;
    EXPECT_EQ(nlohmann::json::parse(result.out).at("sampling").at("kind"), "bsdf");
}

TEST(ProgramGradient, CheckAgrees) {
    const auto json = run({"gradient", kBox, "--param", "white.baseColor", "--param", "light.emission", "--check", "--spp", "8"});
    ASSERT_EQ(json.at("check").size(), 2u);
    for (const auto& check : json.at("check")) {
        EXPECT_TRUE(check.at("agrees").get<bool>());
        EXPECT_LT(check.at("comparisons")[0].at("power").get<double>(), 0.1) << check.at("parameter"); // it could have failed
    }
}

TEST(ProgramOptimize, WritesItsFolder) {
    const test::TemporaryFolder folder;
    run({"render", kBox, "-o", folder / "t.exr", "--spp", "64"});
    const auto json = run({"optimize", kBox, "--param", "white.baseColor", "--set", "white.baseColor=0.4", "--target", folder / "t.exr",
                           "--steps", "20", "--spp", "8", "--rate", "0.04", "-o", folder / "out"});
    ASSERT_EQ(json.at("loss").size(), 20u);
    // At so few samples the edge of the lamp rules the loss; the parameter itself tells. It starts 0.28 to 0.33 away.
    const float truth[] = {0.73f, 0.71f, 0.68f};
    const Image recovered = readImage(folder / "out/parameters/white.baseColor.exr").image;
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(recovered.values[c], truth[c], 0.12) << c;
    for (const char* name : {"loss.csv", "loss.svg", "run.json", "contact_sheet.png", "scene.gltf", "parameters/white.baseColor.exr",
                             "target.exr", "initial.exr", "final.exr"})
        EXPECT_TRUE(fs::exists(folder / "out/" + name)) << name;
    for (const auto& [name, path] : json.at("outputs").items())
        EXPECT_TRUE(fs::exists(path.get<std::string>())) << name;
    const auto values = [&](const std::string& name) { return readImage(folder / ("out/" + name + ".exr")).image.values; };
    const std::vector<float> target = values("target"), final = values("final"), difference = values("difference");
    for (std::size_t i = 0; i < target.size(); ++i)
        ASSERT_EQ(difference[i], final[i] - target[i]) << i;
}

// The least that recovers something: no guide, no roulette, hence few kernels to compile for drivers that are slow at it.
TEST(ProgramOptimize, RecoversWithoutAGuide) {
    const test::TemporaryFolder folder;
    writeExr(folder / "t.exr", Image(32, 24, 3, 0.1f)); // darker than the room can get: all steps go one way
    run({"optimize", kBox, "--param", "white.baseColor", "--target", folder / "t.exr", "--steps", "6", "--spp", "4", "--rate", "0.05",
         "--sampling", "bsdf", "--roulette", "off", "--set", "left.baseColor=0.1,0.2,0.3", "-o", folder / "out"});
    const Image recovered = readImage(folder / "out/parameters/white.baseColor.exr").image;
    const float start[] = {0.73f, 0.71f, 0.68f};
    for (int c = 0; c < 3; ++c)
        EXPECT_LT(recovered.values[c], start[c] - 0.15f) << c; // Adam moves by about its rate a step
    // The scene that is written is the one that was fitted, with what was set and not recovered.
    const auto scene = nlohmann::json::parse(readText(folder / "out/scene.gltf"));
    const auto& materials = scene.at("materials");
    const auto left = std::find_if(materials.begin(), materials.end(), [](const auto& m) { return m.at("name") == "left"; });
    ASSERT_NE(left, materials.end());
    const float set[] = {0.1f, 0.2f, 0.3f};
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(left->at("pbrMetallicRoughness").at("baseColorFactor").at(c).get<float>(), set[c], 1e-6) << c;
}

// A finished run makes its pictures again, from as many samples as are asked for.
TEST(ProgramOptimize, MakesPicturesOfTheSamplesAskedFor) {
    const test::TemporaryFolder folder;
    writeExr(folder / "t.exr", Image(32, 24, 3, 0.1f));
    run({"optimize", kBox, "--param", "white.baseColor", "--target", folder / "t.exr", "--steps", "1", "--spp", "2", "--spp-gradient", "2", "--sampling", "bsdf",
         "--roulette", "off", "--spp-pictures", "256", "-o", folder / "out"});
    const auto picture = [&] { return readImage(folder / "out/final.exr").image.values; };
    const std::vector<float> fine = picture();
    const auto offBy = [&](const char* samples) {
        run({"optimize", "--resume", folder / "out", "--spp-pictures", samples});
        const std::vector<float> made = picture();
        double sum = 0;
        for (std::size_t i = 0; i < fine.size(); ++i)
            sum += (double(made[i]) - fine[i]) * (double(made[i]) - fine[i]);
        return sum;
    };
    EXPECT_EQ(offBy("256"), 0);
    const double few = offBy("2"), more = offBy("32"); // (1/2 + 1/256) / (1/32 + 1/256) is 14; Sobol points do better
    EXPECT_GT(more, 0);
    EXPECT_GT(few, 5 * more);
}

// With a depth of 1 nothing lights what is recovered. That is said once steps have seen every view, of which four take turns.
TEST(ProgramOptimize, SaysWhatNoPathReachedAndThatNothingIsRecovered) {
    const test::TemporaryFolder folder;
    writeExr(folder / "t.exr", Image(16, 12, 3, 0.1f));
    std::vector<std::string> arguments = {"optimize", kBox, "--headless", "--quiet", "--param", kPainting, "--set", kPainting + "=0.5", "--max-depth", "1",
                                          "--spp", "2", "--spp-gradient", "2", "--steps", "5", "--warm-up", "5", "-o", folder / "out"};
    for (int view = 0; view < 4; ++view)
        arguments.insert(arguments.end(), {"--target", "front=" + (folder / "t.exr")});
    const auto result = runProgram(arguments);
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.err.find("all 5 steps are of --warm-up"), std::string::npos) << result.err;
    std::istringstream log(readText(folder / "out/log.jsonl"));
    std::vector<int> told;
    for (std::string line; std::getline(log, line);)
        if (const auto event = nlohmann::json::parse(line); event.value("text", "").find("no path reached " + kPainting) != std::string::npos)
            told.push_back(event.at("step"));
    EXPECT_EQ(told, std::vector{4});
}

TEST(ProgramGradient, SaysWhatAMaterialHasNoUseFor) {
    const test::TemporaryFolder folder;
    const std::vector<std::string> scene = {CMPG_SOURCE_DIR "/tests/reference/mitsuba/brushed.xml", "--define", "width=16", "--define", "height=12", "--headless"};
    std::vector<std::string> inspect = {"inspect", "--json"}, gradient = {"gradient", "--quiet", "--param", "patterned.metallic", "--spp", "1", "-o", folder / "g.exr"};
    inspect.insert(inspect.end(), scene.begin(), scene.end());
    gradient.insert(gradient.end(), scene.begin(), scene.end());
    const auto listed = runProgram(inspect);
    ASSERT_EQ(listed.code, 0) << listed.err;
    for (const auto& p : nlohmann::json::parse(listed.out).at("parameters"))
        if (p.at("name").get<std::string>().starts_with("patterned.")) {
            EXPECT_EQ(p.at("differentiable"), p.at("name") != "patterned.metallic" && p.at("name") != "patterned.specular") << p;
        }
    const auto result = runProgram(gradient);
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.err.find("the gradient of patterned.metallic is zero, as the model of its material has no use for it"), std::string::npos) << result.err;
}

// The box's view is square. What both edges are asked for is meant so.
TEST(ProgramOptimize, SaysThatATargetHasOtherProportions) {
    const test::TemporaryFolder folder;
    writeExr(folder / "wide.exr", Image(32, 24, 3, 0.3f));
    writeExr(folder / "square.exr", Image(25, 24, 3, 0.3f)); // but for a pixel
    const auto warned = [&](const std::string& target, const std::vector<std::string>& more) {
        std::vector<std::string> arguments = {"optimize", kBox, "--headless", "--quiet", "--param", "white.baseColor", "--target", folder / target, "--steps", "1", "--spp", "2",
                                              "--spp-pictures", "2", "-o", folder / "out"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const auto result = runProgram(arguments);
        EXPECT_EQ(result.code, 0) << result.err;
        return result.err.find("times as wide as high") != std::string::npos;
    };
    EXPECT_TRUE(warned("wide.exr", {}));
    EXPECT_TRUE(warned("wide.exr", {"--width", "12"}));
    EXPECT_FALSE(warned("square.exr", {}));
    EXPECT_FALSE(warned("wide.exr", {"--width", "16", "--height", "12"}));
}

// A target that is brighter than any surface explains: its exposure is not the scene's. A grey one tells of no colours.
TEST(ProgramOptimize, SaysWhatTheTargetCannotBe) {
    const test::TemporaryFolder folder;
    writeExr(folder / "t.exr", Image(32, 24, 3, 20.0f));
    const auto result = runProgram({"optimize", kBox, "--headless", "--quiet", "--param", "white.baseColor", "--set", "white.baseColor=0.5", "--max-depth", "4", "--target",
                                    folder / "t.exr", "--steps", "12", "--spp", "4", "-o", folder / "out"});
    ASSERT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.err.find("white.baseColor ended at 1"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("--target-exposure"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("t.exr is grey"), std::string::npos) << result.err;
}

TEST(ProgramOptimize, InterruptionKeepsEverything) {
    const test::TemporaryFolder folder;
    run({"render", kBox, "-o", folder / "t.exr", "--spp", "4"});
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        const std::string target = folder / "t.exr", out = folder / "out";
        execl(CMPG_BINARY, CMPG_BINARY, "optimize", kBox.c_str(), "--param", "white.baseColor", "--target", target.c_str(), "--steps",
              "1000000", "--quiet", "-o", out.c_str(), nullptr);
        _exit(99);
    }
    // Its second step is in loss.csv: header and two rows.
    const auto rows = [&] {
        const std::string csv = readText(folder / "out/loss.csv");
        return std::count(csv.begin(), csv.end(), '\n');
    };
    for (int i = 0; i < 1200 && rows() < 3; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    kill(child, SIGINT);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 130);
    EXPECT_GE(rows(), 3);
    for (const char* name : {"final.exr", "scene.gltf", "contact_sheet.png", "run.json"})
        EXPECT_TRUE(fs::exists(folder / "out/" + name)) << name;
}

} // namespace
} // namespace cmpg

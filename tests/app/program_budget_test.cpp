// Errors and times instead of samples, as a user runs them: what is reached, what is told, what is repeated bit for bit.
#include "command_line.h"
#include "scene/image.h"

#include <cmath>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace cmpg {
namespace {

using test::readText;
using test::runProgram;

const std::string kBox = CMPG_SOURCE_DIR "/scenes/box/scene.gltf";
const std::vector<std::string> kSmall = {"--headless", "--width", "32", "--height", "24", "--max-depth", "4"};

std::vector<std::string> joined(std::vector<std::string> a, const std::vector<std::string>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

double distance(const Image& a, const Image& b) {
    double difference = 0, norm = 0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        difference += std::pow(double(a.values[i]) - double(b.values[i]), 2);
        norm += std::pow(double(a.values[i]), 2);
    }
    return std::sqrt(difference / norm);
}

TEST(ProgramBudget, ReachesTheErrorItIsAskedFor) {
    const test::TemporaryFolder folder;
    const auto run = runProgram(joined({"render", kBox, "--error-target", "3%", "--json", "-o", folder / "a.exr"}, kSmall));
    ASSERT_EQ(run.code, 0) << run.err;
    const auto error = nlohmann::json::parse(run.out).at("error");
    EXPECT_LE(error.at("relative"), 0.03);
    EXPECT_EQ(error.at("batches"), 8);
    EXPECT_EQ(error.at("reached"), true);
    // The reference has a hundredth of the squared error. Twice the interval is far beyond chance.
    ASSERT_EQ(runProgram(joined({"render", kBox, "--spp", "4096", "--seed", "9", "-o", folder / "reference.exr"}, kSmall)).code, 0);
    const double truth = distance(readImage(folder / "a.exr").image, readImage(folder / "reference.exr").image);
    const double middle = error.at("relative"), wide = error.at("high").get<double>() - error.at("low").get<double>();
    EXPECT_NEAR(truth, middle, wide + 0.05 * middle);
}

TEST(ProgramBudget, SaysWhatErrorThereWas) {
    const test::TemporaryFolder folder;
    const auto run = runProgram(joined({"render", kBox, "--error-target", "0.01%", "--spp", "20", "--json", "--quiet", "-o", folder / "a.exr"}, kSmall));
    EXPECT_EQ(run.code, 1);
    EXPECT_NE(run.err.find("was not reached"), std::string::npos) << run.err;
    const auto json = nlohmann::json::parse(run.out);
    EXPECT_EQ(json.at("error").at("reached"), false);
    EXPECT_EQ(json.at("spp"), 16); // as many as eight batches divide
    EXPECT_EQ(readImage(folder / "a.exr").image.width, 32);
    // A scene that the camera sees nothing of has no error to speak of.
    const auto dark = runProgram(joined({"render", kBox, "--set", "*.emission=0", "--error-target", "1%", "--spp", "16", "-o", folder / "b.exr"}, kSmall));
    EXPECT_EQ(dark.code, 1) << dark.err;
}

TEST(ProgramBudget, TimedRunsRepeatBitForBit) {
    const test::TemporaryFolder folder;
    writeExr(folder / "adjoint.exr", Image(32, 24, 3, 0.5f));
    const std::vector<std::string> gradient = {"gradient", kBox, "--param", "painting.baseColor"};
    const std::vector<std::vector<std::string>> commands = {
        {"render", kBox, "--train", "2"},
        joined(gradient, {"--direction", "self"}),
        joined(gradient, {"--adjoint", folder / "adjoint.exr", "--train", "3"}),
        joined(gradient, {"--adjoint", folder / "adjoint.exr", "--pixel-sampling", "uniform", "--sampling", "bsdf", "--error-target", "0.1%"}),
    };
    for (const auto& command : commands) {
        const auto first = runProgram(joined(joined(command, {"--time-budget", "1s", "--json", "-o", folder / "a.exr"}), kSmall));
        const bool target = command.back() == "0.1%";
        ASSERT_EQ(first.code, target ? 1 : 0) << first.err;
        const auto config = nlohmann::json::parse(readText(folder / "run.json"));
        EXPECT_FALSE(config.contains("time-budget"));
        EXPECT_EQ(config.at("batches"), 8);
        EXPECT_EQ(config.at(command[0] == "render" ? "spp" : "spp-gradient"), nlohmann::json::parse(first.out).at("error").at("spp"));
        const std::string once = readText(folder / "a.exr"), written = readText(folder / "run.json");
        const auto again = runProgram({"--config", folder / "run.json", "--headless", "--quiet", "-o", folder / "a.exr"});
        EXPECT_EQ(again.code, first.code) << again.err;
        EXPECT_TRUE(readText(folder / "a.exr") == once) << command[0] << " " << command.back();
        EXPECT_TRUE(readText(folder / "run.json") == written);
    }
}

TEST(ProgramBudget, RecoveriesEndAtAStep) {
    const test::TemporaryFolder folder;
    writeExr(folder / "target.exr", Image(32, 24, 3, 0.3f));
    const std::vector<std::string> optimize = {"optimize", kBox, "--param", "painting.baseColor", "--target", folder / "target.exr",
                                               "--schedule", "cosine", "--steps", "100000", "--headless", "--max-depth", "4"};
    const auto first = runProgram(joined(optimize, {"--time-budget", "2", "-o", folder / "a"}));
    ASSERT_EQ(first.code, 0) << first.err;
    const auto config = nlohmann::json::parse(readText(folder / "a/run.json"));
    EXPECT_GE(config.at("stop-after"), 1);
    EXPECT_LT(config.at("stop-after"), 100000);
    EXPECT_EQ(config.at("steps"), 100000); // the schedule's
    const std::string steps = std::to_string(config.at("stop-after").get<int>());
    EXPECT_NE(first.err.find("step " + steps + "/100000"), std::string::npos) << first.err; // the last one
    const auto again = runProgram({"--config", folder / "a/run.json", "--headless", "-o", folder / "b"});
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_NE(again.err.find("step " + steps + "/" + steps), std::string::npos) << again.err; // what is left is that of this run
    const std::string values = "/parameters/painting.baseColor.exr";
    EXPECT_TRUE(readText(folder / ("a" + values)) == readText(folder / ("b" + values)));
    EXPECT_GE(config.at("spp-pictures"), 16);
    EXPECT_LE(config.at("spp-pictures"), 64);
    for (const std::string picture : {"/initial.exr", "/final.exr"})
        EXPECT_TRUE(readText(folder / ("a" + picture)) == readText(folder / ("b" + picture))) << picture;
}

TEST(ProgramBudget, RecoveriesSampleUntilGradientsAreGood) {
    const test::TemporaryFolder folder;
    writeExr(folder / "target.exr", Image(32, 24, 3, 0.3f));
    const std::vector<std::string> optimize = {"optimize", kBox, "--param", "painting.baseColor", "--target", folder / "target.exr",
                                               "--steps", "2", "--headless", "--max-depth", "4", "--json", "--quiet"};
    const auto easy = runProgram(joined(optimize, {"--error-target", "60%", "--spp-gradient", "512", "-o", folder / "a"}));
    ASSERT_EQ(easy.code, 0) << easy.err;
    EXPECT_EQ(nlohmann::json::parse(easy.out).at("error").at("missed"), 0);
    const auto hard = runProgram(joined(optimize, {"--error-target", "0.01%", "--spp-gradient", "8", "-o", folder / "b"}));
    EXPECT_EQ(hard.code, 1) << hard.err;
    EXPECT_EQ(nlohmann::json::parse(hard.out).at("error").at("missed"), 2);
}

// Each process has the time of its own, and goes on where the one before ended: together they did what one of as many steps does.
TEST(ProgramBudget, TimedRecoveriesGoOn) {
    const test::TemporaryFolder folder;
    writeExr(folder / "target.exr", Image(32, 24, 3, 0.3f));
    const auto first = runProgram({"optimize", kBox, "--param", "painting.baseColor", "--target", folder / "target.exr", "--schedule", "cosine", "--steps",
                                   "100000", "--headless", "--max-depth", "4", "--time-budget", "2", "--checkpoint-every", "1", "-o", folder / "a"});
    ASSERT_EQ(first.code, 0) << first.err;
    const auto steps = [&] { return nlohmann::json::parse(readText(folder / "a/run.json")).at("stop-after").get<std::uint32_t>(); };
    const std::uint32_t before = steps();
    const auto second = runProgram({"optimize", "--resume", folder / "a", "--headless", "--quiet"});
    ASSERT_EQ(second.code, 0) << second.err;
    EXPECT_GT(steps(), before);
    ASSERT_EQ(runProgram({"--config", folder / "a/run.json", "--headless", "--quiet", "-o", folder / "b"}).code, 0);
    for (const char* name : {"parameters/painting.baseColor.exr", "gradients/painting.baseColor.exr", "final.exr"})
        EXPECT_TRUE(readText(folder / (std::string("a/") + name)) == readText(folder / (std::string("b/") + name))) << name;
    const auto past = runProgram({"optimize", "--resume", folder / "a", "--headless", "--quiet", "--stop-after", std::to_string(before)});
    EXPECT_EQ(past.code, 2);
    EXPECT_NE(past.err.find("--stop-after"), std::string::npos) << past.err;
}

TEST(ProgramBudget, ErrorsAreThoseOfTheWholeRecovery) {
    const test::TemporaryFolder folder;
    writeExr(folder / "target.exr", Image(32, 24, 3, 0.3f));
    const auto run = [&](const std::string& name, const std::vector<std::string>& more) {
        return runProgram(joined({"optimize", kBox, "--param", "painting.baseColor", "--target", folder / "target.exr", "--steps", "4", "--headless", "--max-depth",
                                  "4", "--spp-gradient", "16", "--json", "--quiet", "-o", folder / name},
                                 more));
    };
    const std::vector<std::string> target = {"--error-target", "0.01%"}, goOn = joined(target, {"--resume", folder / "a", "--stop-after", "4"});
    const auto whole = run("whole", target), half = run("a", joined(target, {"--stop-after", "2"}));
    ASSERT_EQ(whole.code, 1) << whole.err;
    EXPECT_EQ(nlohmann::json::parse(half.out).at("error").at("missed"), 2);
    const auto expected = nlohmann::json::parse(whole.out).at("error");
    EXPECT_EQ(expected.at("missed"), 4);
    for (const char* what : {"the other half", "nothing but to write the results again"}) {
        const auto rest = run("a", goOn);
        EXPECT_EQ(rest.code, 1) << what << "\n" << rest.err;
        EXPECT_EQ(nlohmann::json::parse(rest.out).at("error"), expected) << what;
        EXPECT_TRUE(readText(folder / "a/parameters/painting.baseColor.exr") == readText(folder / "whole/parameters/painting.baseColor.exr")) << what;
    }
    const auto refused = run("a", {"--resume", folder / "a", "--error-target", "1%"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find("error-target differs: it has 1e-04, this one 0.01"), std::string::npos) << refused.err;
}

} // namespace
} // namespace cmpg

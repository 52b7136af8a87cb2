// The command line: where options may stand, what they mean, what is refused, and the way through run.json and back.
#include "command_line.h"

#include "app/parse_options.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace cmpg {
namespace {

using test::parse;
using test::parseCode;

TEST(Options, AFolderWithoutACheckpointIsNotResumedWithoutItsScene) {
    const std::string folder = testing::TempDir();
    try {
        parse({"optimize", "--resume", folder});
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind, ErrorKind::Usage);
        EXPECT_NE(std::string(error.what()).find("no checkpoint"), std::string::npos) << error.what();
    }
}

TEST(Options, CommonOptionsStandBeforeOrAfterTheCommand) {
    const std::vector<std::string> common = {"--spp",          "7",
                                             "--spp-gradient", "3",
                                             "--width",        "33",
                                             "--height",       "21",
                                             "--camera",       "side",
                                             "--max-depth",    "5",
                                             "--seed",         "18446744073709551615",
                                             "--device",       "1",
                                             "--memory",       "64",
                                             "--set",          "a.b=0.5",
                                             "--sampler",      "independent",
                                             "--sampling",     "bsdf",
                                             "--no-nee",       "--pixel-sampling",
                                             "uniform",        "--json",
                                             "--quiet"};
    const std::vector<std::vector<std::string>> commands = {{"render", "s.gltf", "-o", "a.exr"},
                                                            {"gradient", "s.gltf", "--param", "p", "-o", "a.exr"},
                                                            {"optimize", "s.gltf", "--param", "p", "--target", "t.exr", "-o", "d"},
                                                            {"inspect", "s.gltf"},
                                                            {"view", "a.exr", "-o", "a.png"},
                                                            {"guide", "a.guide"}};
    for (const auto& command : commands)
        for (const bool before : {false, true}) {
            std::vector<std::string> arguments = {"--headless"};
            if (before)
                arguments.insert(arguments.end(), common.begin(), common.end());
            arguments.insert(arguments.end(), command.begin(), command.end());
            if (!before)
                arguments.insert(arguments.end(), common.begin(), common.end());
            const Options o = parse(arguments);
            SCOPED_TRACE(command[0] + (before ? ", before" : ", after"));
            EXPECT_EQ(commandName(o.command), command[0]);
            EXPECT_EQ(o.input, command[1]);
            EXPECT_TRUE(o.headless && o.json && o.quiet && o.noLightSampling);
            EXPECT_EQ(o.spp, 7u);
            EXPECT_EQ(o.sppGradient, 3u);
            EXPECT_EQ(o.width, 33u);
            EXPECT_EQ(o.height, 21u);
            EXPECT_EQ(o.maxDepth, 5u);
            EXPECT_EQ(o.seed, ~std::uint64_t(0));
            EXPECT_EQ(o.memory, 64u);
            EXPECT_EQ(o.camera, "side");
            EXPECT_EQ(o.device, "1");
            EXPECT_EQ(o.set, std::vector<std::string>{"a.b=0.5"});
            EXPECT_EQ(o.sampler, Sampler::Independent);
            EXPECT_EQ(o.pixelSampling, PixelSampling::Uniform);
        }
}

TEST(Options, RepeatedOptionsTakeOneValueEach) {
    const Options o = parse({"gradient", "--param", "a", "s.gltf", "--param", "b*", "--set", "a=1", "-o", "d", "--set", "b=2"});
    EXPECT_EQ(o.input, "s.gltf");
    EXPECT_EQ(o.param, (std::vector<std::string>{"a", "b*"}));
    EXPECT_EQ(o.set, (std::vector<std::string>{"a=1", "b=2"}));
}

TEST(Options, SamplesPerPixelDependOnTheCommand) {
    const auto render = parse({"render", "s", "-o", "a.exr"});
    EXPECT_EQ(render.effectiveSpp(), 64u);
    const auto gradient = parse({"gradient", "s", "--param", "p", "-o", "a.exr", "--spp", "9"});
    EXPECT_EQ(gradient.effectiveSppGradient(), 9u);
    const auto optimize = parse({"optimize", "s", "--param", "p", "--target", "t", "-o", "d"});
    EXPECT_EQ(optimize.effectiveSpp(), 16u);
    EXPECT_EQ(optimize.effectiveSppGradient(), 4u);
}

TEST(Options, LearningPassesHaveTogetherWhatThePassHas) {
    const auto samples = [](std::vector<std::string> more) {
        std::vector<std::string> arguments{"render", "s", "-o", "a.exr"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return parse(arguments).effectiveTrainSpp();
    };
    EXPECT_EQ(samples({"--spp", "64", "--train", "8"}), 8u);
    EXPECT_EQ(samples({"--spp", "65", "--train", "8"}), 9u);
    EXPECT_EQ(samples({"--spp", "16", "--train", "8"}), 4u); // at least
    EXPECT_EQ(samples({"--spp", "2", "--train", "8"}), 2u);  // but no more than the pass
    EXPECT_EQ(samples({"--spp", "64", "--train", "1"}), 64u);
    EXPECT_EQ(samples({"--spp", "64", "--train", "8", "--batches", "8"}), 8u);
    EXPECT_EQ(samples({"--spp", "64", "--train", "8", "--train-spp", "3"}), 3u);
}

TEST(Options, QualitySetsWhatIsNotGiven) {
    const std::vector<std::string> render = {"render", "s", "-o", "a.exr", "--quality"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), render.begin(), render.end());
        return parse(more);
    };
    EXPECT_EQ(with({"preview"}).effectiveSpp(), 16u);
    EXPECT_EQ(with({"accurate"}).effectiveSpp(), 256u);
    EXPECT_EQ(with({"accurate", "--spp", "9"}).effectiveSpp(), 9u);
    EXPECT_EQ(with({"preview"}).effectiveDepth(8), 4u);
    EXPECT_EQ(with({"preview"}).effectiveDepth(1), 1u);
    EXPECT_EQ(with({"accurate", "--max-depth", "3"}).effectiveDepth(8), 3u);
    EXPECT_EQ(parse({"render", "s", "-o", "a.exr"}).effectiveDepth(8), 8u);
    EXPECT_EQ(toConfig(with({"preview"})).at("quality"), "preview");
}

TEST(Options, ErrorsAndTimesHaveUnits) {
    const std::vector<std::pair<std::string, float>> times = {{"90", 90.f}, {"1.5s", 1.5f}, {"2m", 120.f}, {"5 min", 300.f}, {"1h", 3600.f}};
    for (const auto& [text, seconds] : times)
        EXPECT_EQ(parse({"render", "s", "-o", "a.exr", "--time-budget", text}).timeBudget, seconds) << text;
    EXPECT_EQ(parse({"render", "s", "-o", "a.exr", "--error-target", "2%"}).errorTarget, 0.02f);
    EXPECT_EQ(parse({"render", "s", "-o", "a.exr", "--error-target", "0.02"}).errorTarget, 0.02f);
    EXPECT_EQ(parse({"render", "s", "-o", "a.exr", "--error-target", "2%"}).effectiveBatches(), 8u);
    EXPECT_EQ(parse({"render", "s", "-o", "a.exr"}).effectiveBatches(), 0u);
    EXPECT_EQ(parse({"compare", "s", "--param", "p", "-o", "d", "--time", "1min"}).time, 60.f);
}

TEST(Options, WholeNumbersAreDecimal) {
    EXPECT_EQ(parse({"render", "s", "-o", "a.exr", "--seed", "010"}).seed, 10u);
    EXPECT_EQ(parse({"render", "s", "-o", "a.exr", "--seed", "08"}).seed, 8u);
    EXPECT_EQ(parse({"render", "s", "-o", "a.exr", "--width=0012"}).width, 12u);
    EXPECT_EQ(parse({"render", "s", "-o", "a.exr", "--spp", "0004"}).spp, 4u);
}

TEST(Options, NegativeNumbersAreValues) {
    EXPECT_FLOAT_EQ(parse({"view", "a.exr", "-o", "a.png", "--exposure", "-1.5"}).exposure, -1.5f);
}

TEST(Options, RefusesWhatMakesNoSense) {
    const std::vector<std::vector<std::string>> wrong = {
        {},
        {"paint", "s"},
        {"render"},
        {"render", "s"}, // no -o
        {"render", "s", "-o"},
        {"render", "s", "t", "-o", "a.exr"},
        {"render", "s", "-o", "a.exr", "--param", "p"}, // of another command
        {"render", "s", "-o", "a.exr", "--spp", "0"},
        {"render", "s", "-o", "a.exr", "--spp", "-4"},
        {"render", "s", "-o", "a.exr", "--spp", "4.5"},
        {"render", "s", "-o", "a.exr", "--spp", "many"},
        {"render", "s", "-o", "a.exr", "--spp", ""},
        {"render", "s", "-o", "a.exr", "--spp="},
        {"render", "s", "-o", "a.exr", "--spp", "0x10"},
        {"render", "s", "-o", "a.exr", "--spp", "4294967300"}, // 4 in 32 bits
        {"render", "s", "-o", "a.exr", "--seed", "18446744073709551616"},
        {"render", "s", "-o", "a.exr", "--seed", ""},
        {"render", "s", "-o", "a.exr", "--guide-share", ""},
        {"render", "s", "-o", "a.exr", "--guide-share="},
        {"render", "s", "-o", "a.exr", "--guide-share", "0x1p-2"},
        {"render", "s", "-o", "a.exr", "--environment-rotation", ""},
        {"render", "s", "-o", "a.exr", "--error-target", ""},
        {"render", "s", "-o", "a.exr", "--error-target", "0x1p-2"},
        {"render", "s", "-o", "a.exr", "--time-budget", "0x1p4s"},
        {"optimize", "s", "--param", "p", "--target", "t", "-o", "d", "--prior", ""},
        {"view", "a.exr", "-o", "a.png", "--scale", ""},
        {"view", "a.exr", "-o", "a.png", "--exposure", "0x10"},
        {"render", "s", "-o", "a.exr", "--spp", "99999999999999"},
        {"render", "s", "-o", "a.exr", "--width", "1000000"},
        {"render", "s", "-o", "a.exr", "--max-depth", "0"},
        {"render", "s", "-o", "a.exr", "--memory", "0"},
        {"render", "s", "-o", "a.exr", "--seed", "-1"},
        {"render", "s", "-o", "a.exr", "--sampler", "halton"},
        {"render", "s", "-o", "a.exr", "--sampling", "magic"},
        {"render", "s", "-o", "a.exr", "--set", "novalue"},
        {"render", "s", "-o", "a.exr", "--texture", "p"},
        {"render", "s", "-o", "a.exr", "--texture", "=4x4"},
        {"render", "s", "-o", "a.exr", "--texture", "p=4"},
        {"render", "s", "-o", "a.exr", "--texture", "p=4x4x4"},
        {"render", "s", "-o", "a.exr", "--texture", "p=0x4"},
        {"render", "s", "-o", "a.exr", "--texture", "p=-4x4"},
        {"render", "s", "-o", "a.exr", "--texture", "p=4x99999"},
        {"render", "s", "-o", "a.exr", "--config", "/nonexistent/run.json"},
        {"render", "s", "-o", "a.exr", "--filter", "mitchell"},
        {"render", "s", "-o", "a.exr", "--filter", "box:1"},
        {"render", "s", "-o", "a.exr", "--filter", "tent:"},
        {"render", "s", "-o", "a.exr", "--filter", "tent:0"},
        {"render", "s", "-o", "a.exr", "--filter", "tent:33"},
        {"render", "s", "-o", "a.exr", "--filter", "gaussian:wide"},
        {"render", "s", "-o", "a.exr", "--filter", "gaussian:nan"},
        {"render", "s", "-o", "a.exr", "--filter", "gaussian:-1"},
        {"render", "s", "-o", "a.exr", "--save-guide", "a.guide"}, // learns none
        {"gradient", "s", "--param", "p", "-o", "a.exr", "--save-guide", "a.guide", "--train", "0"},
        {"gradient", "s", "--param", "p", "--check", "--train", "2", "--save-guide", "a.guide"}, // no passes that could learn
        {"gradient", "s", "-o", "a.exr"}, // no --param
        {"gradient", "s", "--param", "p"},
        {"gradient", "s", "--param", "p", "-o", "a.exr", "--adjoint", "a", "--target", "b"},
        {"gradient", "s", "--param", "p", "-o", "a.exr", "--target", "a", "--target", "b"},
        {"gradient", "s", "--param", "p", "--check", "--adjoint", "a.exr"},
        {"gradient", "s", "--param", "p", "-o", "a.exr", "--adjoint", "a.exr", "--direction", "self"},
        {"gradient", "s", "--param", "p", "-o", "a.exr", "--adjoint", "a.exr", "--layers", "l.exr"},
        {"gradient", "s", "--param", "p", "-o", "a.exr", "--positivize", "--layers", "l.exr"},
        {"gradient", "s", "--param", "p", "--check", "--layers", "l.exr"},
        {"gradient", "s", "--param", "p", "-o", "a.exr", "--target", "a", "--loss", "huber"},
        {"optimize", "s", "--param", "p", "-o", "d"}, // no --target
        {"optimize", "s", "--target", "t", "-o", "d"},
        {"optimize", "s", "--param", "p", "--target", "t"},
        {"optimize", "s", "--param", "p", "--target", "t", "-o", "d", "--steps", "0"},
        {"optimize", "s", "--param", "p", "--target", "t", "-o", "d", "--total-variation", "nan"},
        {"view", "a.exr", "-o", "a.png", "--exposure", "inf"},
        {"render", "s", "-o", "a.exr", "--error-target", "0"},
        {"render", "s", "-o", "a.exr", "--error-target", "small"},
        {"render", "s", "-o", "a.exr", "--error-target", "1%", "--spp", "7"}, // fewer than batches
        {"render", "s", "-o", "a.exr", "--error-target", "1%", "--layers", "l.exr"},
        {"render", "s", "-o", "a.exr", "--time-budget", "soon"},
        {"render", "s", "-o", "a.exr", "--time-budget", "-1s"},
        {"render", "s", "-o", "a.exr", "--batches", "4"},
        {"render", "s", "-o", "a.exr", "--batches", "8", "--spp", "20"},
        {"render", "s", "-o", "a.exr", "--guide-share", "1"},
        {"render", "s", "-o", "a.exr", "--cell-records", "0"},
        {"render", "s", "-o", "a.exr", "--quality", "best"},
        {"gradient", "s", "--param", "p", "--check", "--time-budget", "5s"},
        {"optimize", "s", "--param", "p", "--target", "t", "-o", "d", "--batches", "8"}, // errors of steps have theirs
        {"tradeoff", "s", "-o", "d"}, // no --param
        {"tradeoff", "s", "--param", "p"},
        {"render", "s", "-o", "a.exr", "view", "a.exr"},
    };
    for (const auto& arguments : wrong) {
        std::string line;
        for (const auto& a : arguments)
            line += a + " ";
        EXPECT_EQ(parseCode(arguments), ErrorKind::Usage) << line;
    }
}

TEST(Options, GuidesAreSavedWhereThereIsOne) {
    const std::vector<std::string> render = {"render", "s", "-o", "a.exr", "--save-guide", "a.guide"};
    try {
        parse(render);
        FAIL();
    } catch (const Error& e) {
        EXPECT_NE(e.remedy.find("--train"), std::string::npos);
    }
    for (const std::vector<std::string>& more : {std::vector<std::string>{"--train", "2"}, {"--load-guide", "b.guide"}}) {
        std::vector<std::string> arguments = render;
        arguments.insert(arguments.end(), more.begin(), more.end());
        EXPECT_EQ(parseCode(arguments), std::nullopt);
    }
    EXPECT_EQ(parseCode({"optimize", "s", "--param", "p", "--target", "t", "-o", "d", "--save-guide", "a.guide"}), std::nullopt);
}

TEST(Options, HelpNamesEveryCommandAndExitCode) {
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{"--help"}, {"-h"}, {"render", "--help"}})
        EXPECT_THROW(parse(arguments), HelpRequested);
    try {
        parse({"--help"});
    } catch (const HelpRequested& help) {
        for (const char* word :
             {"render", "gradient", "optimize", "inspect", "view", "guide", "--list-devices", "--version", "--spp-gradient", "=false", "Exit codes", "130"})
            EXPECT_NE(help.text.find(word), std::string::npos) << word;
    }
}

// Every option away from its default, so that one that is lost on the way shows.
TEST(Options, ConfigurationSurvivesTheRoundTrip) {
    const std::vector<std::vector<std::string>> runs = {
        {"render",      "/s.gltf",
         "-o",          "a.exr",
         "--spp",       "3",
         "--width",     "8",
         "--height",    "9",
         "--camera",    "c",
         "--max-depth", "2",
         "--seed",      "18446744073709551615",
         "--device",    "llvm",
         "--memory",    "77",
         "--set",       "p=1,2,3",
         "--sampler",   "independent",
         "--filter",    "gaussian:0.7",
         "--no-nee",    "--pixel-sampling",
         "uniform"},
        {"gradient", "/s.gltf", "-o", "a.exr", "--param", "p", "--param", "q*", "--direction", "self"},
        {"gradient", "/s.gltf", "-o", "a.exr", "--param", "p", "--adjoint", "/a.exr", "--spp-gradient", "5"},
        {"gradient", "/s.gltf", "--param", "p", "--check"},
        {"optimize",
         "/s.gltf",
         "-o",
         "d",
         "--param",
         "p",
         "--target",
         "c=/t.exr",
         "--loss",
         "relative-mse",
         "--mask",
         "/m.png",
         "--target-exposure",
         "-0.3",
         "--steps",
         "12",
         "--optimizer",
         "sgd",
         "--rate",
         "0.1",
         "--rate",
         "normal=0.2",
         "--schedule",
         "cosine",
         "--final-rate",
         "0.7",
         "--total-variation",
         "0.001"},
        {"view", "/a.exr", "-o", "a.png", "--signed", "--exposure", "0.1", "--scale", "1e-5"},
        {"render", "/s.gltf", "-o", "a.exr", "--quality", "accurate", "--train", "2", "--train-spp", "3", "--guide-share", "0.25", "--cell-records", "100",
         "--direction-share", "0.02", "--forgetting", "0.5", "--roulette-effort", "2", "--error-target", "3%", "--batches", "16", "--spp", "640"},
        {"optimize", "/s.gltf", "-o", "d", "--param", "p", "--target", "/t.exr", "--time-budget", "2min", "--stop-after", "3", "--error-target", "0.5"},
        {"optimize", "/s.gltf", "-o", "d", "--param", "p", "--target", "/t.exr", "--save-guide", "/a.guide"},
        {"tradeoff", "/s.gltf", "-o", "d", "--param", "p", "--direction", "self", "--time", "1h", "--seeds", "2"},
        {"guide", "/a.guide", "--validate", "--csv", "--cell", "3", "--weights", "1,2"},
        {"guide", "/a.guide", "--weights", ""}, // refused later, and so when it is run again
    };
    for (const auto& arguments : runs) {
        const nlohmann::ordered_json config = toConfig(parse(arguments));
        Options back;
        applyConfig(nlohmann::json::parse(config.dump()), back);
        EXPECT_EQ(toConfig(back), config) << config.dump(1);
        for (const char* key : {"output", "json", "quiet", "config"})
            EXPECT_FALSE(config.contains(key)) << key; // not what makes the result
    }
    EXPECT_EQ(toConfig(parse(runs[4])).at("target-exposure").dump(), "-0.3"); // a float in few digits
}

// run.json names files from anywhere, and leaves alone what is none, whatever lies about where it was written.
TEST(Options, ConfigurationNamesFilesAbsolutely) {
    const test::TemporaryFolder folder;
    const std::filesystem::path before = std::filesystem::current_path();
    std::filesystem::current_path(folder.path());
    for (const char* made : {"0.5", "1,2,3", "map", "run=3"})
        std::filesystem::create_directory(made);
    for (const char* file : {"a.exr", "b=c.exr", "c.exr", "7", "run=3/target.exr"})
        test::writeText(file, "");
    const auto config = [](const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"optimize", "/s.gltf", "-o", "d", "--param", "p"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return toConfig(parse(arguments));
    };
    const std::string here = folder.path() + "/";
    using Texts = std::vector<std::string>;
    EXPECT_EQ(config({"--target", "a.exr", "--set", "a.b=0.5", "--set", "a.b=1,2,3", "--set", "a.b=7", "--set", "a.b=map", "--set", "a.b=a.exr"})
                  .at("set"),
              (Texts{"a.b=0.5", "a.b=1,2,3", "a.b=7", "a.b=map", "a.b=" + here + "a.exr"}));
    EXPECT_EQ(config({"--target", "a.exr", "--target", "run=3/target.exr", "--target", "side=a.exr", "--target", "side=gone.exr", "--target", "run=3"})
                  .at("target"),
              (Texts{here + "a.exr", here + "run=3/target.exr", "side=" + here + "a.exr", "side=gone.exr", "run=3"}));
    EXPECT_EQ(config({"--target", "b=c.exr"}).at("target"), Texts{"b=c.exr"}); // a file, or another of the camera b, which the scene decides
    std::filesystem::current_path(before);
}

TEST(Options, CommandLineOverridesTheConfiguration) {
    const test::TemporaryFolder folder;
    const std::string file = folder / "run.json";
    test::writeText(
        file,
        R"({"command": "render", "input": "/s.gltf", "spp": 5, "no-nee": true, "set": ["a=1", "b=2"], "seed": 4, "made-with": {"version": "?"}})");
    const Options o = parse({"--config", file, "-o", "a.exr", "--spp", "6", "--set", "c=3"});
    EXPECT_EQ(o.command, Command::Render);
    EXPECT_EQ(o.input, "/s.gltf");
    EXPECT_EQ(o.spp, 6u);
    EXPECT_EQ(o.seed, 4u);
    EXPECT_TRUE(o.noLightSampling);
    EXPECT_EQ(o.set, std::vector<std::string>{"c=3"}); // replaced, not appended
    const Options other = parse({"inspect", "/t.gltf", "--config=" + file, "--no-nee=false"});
    EXPECT_EQ(other.command, Command::Inspect);
    EXPECT_EQ(other.input, "/t.gltf");
    EXPECT_FALSE(other.noLightSampling);
    EXPECT_EQ(other.set.size(), 2u);
}

TEST(Options, TheConfigurationsCommandTakesItsOwnOptions) {
    const test::TemporaryFolder folder;
    const std::string file = folder / "run.json";
    test::writeText(file, R"({"command": "optimize", "input": "/s.gltf", "param": ["a.b"], "target": ["/t.exr"], "steps": 5})");
    const Options o = parse({"--config", file, "--steps", "7", "-o", "view", "--loss=l1"}); // a folder named as a command
    EXPECT_EQ(o.command, Command::Optimize);
    EXPECT_EQ(o.input, "/s.gltf");
    EXPECT_EQ(o.recovery.steps, 7u);
    EXPECT_EQ(o.output, "view");
    EXPECT_EQ(o.loss, Loss::L1);
    EXPECT_EQ(parseCode({"--config", file, "-o", "run", "--layers", "l.exr"}), ErrorKind::Usage); // of another command
}

TEST(Options, RefusesBadConfigurations) {
    const test::TemporaryFolder folder;
    const std::string file = folder / "run.json";
    for (const char* text : {"", "{", "[]", "3", R"({"spp": "4"})", R"({"spp": -4})", R"({"spp": 4.5})", R"({"spp": 5000000000})",
                             R"({"sppp": 4})", R"({"set": "a=1"})", R"({"set": [1]})", R"({"sampler": "halton"})", R"({"no-nee": 1})",
                             R"({"command": "paint"})", R"({"spp": 0})", R"({"camera": null})"}) {
        test::writeText(file, text);
        EXPECT_EQ(parseCode({"render", "s", "-o", "a.exr", "--config", file}), ErrorKind::Usage) << text;
    }
}

// A scene alone is to be opened in a window, wherever its options stand.
TEST(Options, ASceneAloneOpensAWindow) {
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"s.gltf", "--target", "t.exr", "--param", "p"}, {"--spp", "7", "s.gltf", "--target", "t.exr", "--param", "p"},
          {"--target", "t.exr", "--param", "p", "s.gltf"}, {"open", "s.gltf", "--target", "t.exr", "--param", "p"}}) {
        const Options o = parse(arguments);
        EXPECT_EQ(o.command, Command::Open);
        EXPECT_EQ(o.input, "s.gltf");
        EXPECT_EQ(o.target, std::vector<std::string>{"t.exr"});
        EXPECT_EQ(o.param, std::vector<std::string>{"p"});
    }
    EXPECT_EQ(parseCode({"--headless", "s.gltf"}), ErrorKind::Usage);
    EXPECT_EQ(parseCode({"rendr", "s.gltf"}), ErrorKind::Usage);
    EXPECT_EQ(parseCode({"s.gltf", "--frobnicate"}), ErrorKind::Usage);
}

TEST(Options, WhatWasMeantIsSaid) {
    struct Case {
        std::vector<std::string> arguments;
        std::string what, remedy; // parts of them
    };
    for (const Case& c : std::vector<Case>{
             {{"rendr", "s.gltf"}, "'rendr' is neither a command nor a scene", "did you mean render?"},
             {{"frobnicate", "s.gltf"}, "'frobnicate' is neither", "see cmpg-vk --help"},
             {{"render", "s.gltf", "--sppp", "3"}, "render has no option --sppp", "did you mean --spp?"},
             {{"render", "s.gltf", "--sppp=3"}, "render has no option --sppp", "did you mean --spp?"},
             {{"render", "s.gltf", "--steps", "3"}, "render has no option --steps", "see cmpg-vk render --help"}, // optimize has
             {{"s.gltf", "--targte", "x.exr"}, "no option --targte", "did you mean --target?"},
             {{"render", "s.gltf", "--spp", "3", "--spp", "4"}, "--spp was given 2 times", "see cmpg-vk --help"},
             {{"view", "a.exr", "--exposure", "much"}, "--exposure does not take 'much'", "see cmpg-vk --help"},
             {{"view", "a.exr", "--exposure", "--quiet"}, "--exposure lacks its value: --quiet comes next", "see cmpg-vk --help"},
             {{"render", "s.gltf", "-o"}, "--output lacks its value", "see cmpg-vk --help"},
             {{"--list-devces"}, "there is no option --list-devces", "did you mean --list-devices?"},
             {{"optimize", "s.gltf", "--param", "a", "b", "c"}, "'b' belongs to no option", "--param A --param B"}}) {
        std::string line;
        for (const std::string& argument : c.arguments)
            line += argument + " ";
        try {
            parse(c.arguments);
            ADD_FAILURE() << line;
        } catch (const Error& e) {
            EXPECT_EQ(e.kind, ErrorKind::Usage) << line;
            EXPECT_NE(std::string(e.what()).find(c.what), std::string::npos) << line << ": " << e.what();
            EXPECT_NE(e.remedy.find(c.remedy), std::string::npos) << line << ": " << e.remedy;
        }
    }
}

} // namespace
} // namespace cmpg

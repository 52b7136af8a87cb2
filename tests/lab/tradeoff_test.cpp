// Knobs, frontiers and reports of a trade-off measurement, and the command on a small image of the box.
#include "lab/tradeoff_report.h"
#include "base/error.h"
#include "app/command_line.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <set>

namespace cmpg {
namespace {

using test::readText;
using test::runProgram;

Options tradeoffOptions() { return test::parse({"tradeoff", "s.gltf", "--param", "p", "--target", "t.exr", "-o", "d"}); }

TEST(TradeoffKnobs, ChangeOneOptionEachAndNothingElse) {
    const Options base = tradeoffOptions();
    std::vector<std::string> unused;
    const std::vector<Setting> settings = singleSettings(base, 8, {.steps = true, .reverse = true, .guide = true, .roulette = true}, unused);
    EXPECT_TRUE(unused.empty());
    EXPECT_EQ(settings.front().name(), "defaults");
    EXPECT_EQ(toConfig(settings.front().options), toConfig(base));
    std::set<std::string> options, names;
    for (std::size_t i = 1; i < settings.size(); ++i) {
        const Setting& s = settings[i];
        ASSERT_EQ(s.changes.size(), 1u);
        EXPECT_TRUE(names.insert(s.name()).second) << s.name();
        options.insert(s.changes.front().option);
        const auto config = toConfig(s.options), defaults = toConfig(base);
        int differences = 0;
        for (const auto& [key, value] : config.items())
            differences += !defaults.contains(key) || defaults[key] != value;
        if (s.changes.front().option == "quality")
            EXPECT_EQ(differences, 3) << s.name(); // both samples follow
        else
            EXPECT_EQ(differences, 1) << s.name();
        EXPECT_NO_THROW(validate(s.options)) << s.name();
        // The name is what a user would type.
        std::vector<std::string> arguments = {"tradeoff", "s.gltf", "--param", "p", "--target", "t.exr", "-o", "d"};
        const std::string name = s.name();
        const std::size_t space = name.find(' ');
        arguments.push_back(name.substr(0, space));
        if (space != std::string::npos)
            arguments.push_back(name.substr(space + 1));
        EXPECT_EQ(toConfig(test::parse(arguments)), config) << name;
    }
    for (const char* expected : {"quality", "spp", "spp-gradient", "max-depth", "sampling", "guide-share", "cell-records", "direction-share",
                                 "train", "roulette", "roulette-effort", "pixel-sampling", "sampler", "no-nee", "positivize"})
        EXPECT_TRUE(options.contains(expected)) << expected;
}

TEST(TradeoffKnobs, LeavesOutWhatNothingDependsOn) {
    std::vector<std::string> unused;
    const std::vector<Setting> settings = singleSettings(tradeoffOptions(), 8, {}, unused);
    EXPECT_EQ(unused, (std::vector<std::string>{"spp", "guide-share", "cell-records", "direction-share", "train", "roulette",
                                                "roulette-effort", "pixel-sampling"}));
    for (const Setting& s : settings)
        for (const KnobChange& change : s.changes)
            EXPECT_EQ(std::find(unused.begin(), unused.end(), change.option), unused.end());
}

TEST(TradeoffKnobs, CombineInPairs) {
    const std::vector<KnobChange> best = {{"max-depth", 4u}, {"guide-share", 0.75}, {"no-nee", true}};
    const std::vector<Setting> settings = combinedSettings(tradeoffOptions(), best);
    ASSERT_EQ(settings.size(), 4u);
    EXPECT_EQ(settings[0].name(), "--max-depth 4 --guide-share 0.75");
    EXPECT_EQ(settings[2].name(), "--guide-share 0.75 --no-nee");
    EXPECT_EQ(settings[3].name(), "--max-depth 4 --guide-share 0.75 --no-nee");
    EXPECT_EQ(settings[3].options.maxDepth, 4u);
    EXPECT_TRUE(settings[3].options.noLightSampling);
    EXPECT_EQ(combinedSettings(tradeoffOptions(), {best[0], best[1]}).size(), 1u);
    EXPECT_EQ(combinedSettings(tradeoffOptions(), {best[0], best[1], best[2], {"sampler", "independent"}}).size(), 6u + 4 + 1);
}

SettingResult result(const std::vector<KnobChange>& changes, double seconds, double variance, double bias = 0) {
    SettingResult r;
    r.setting = makeSetting(tradeoffOptions(), changes);
    r.secondsPerPass = seconds;
    r.relativeVariance = {variance, 0.1 * variance};
    r.bias.along = r.bias.squared = bias;
    r.bias.squared *= bias;
    r.bias.interval = 0.001;
    if (bias != 0)
        r.bias.verdict = Bias::Verdict::Biased;
    r.squaredBias = bias * bias;
    r.gain = {1 / (seconds * variance), 0.1};
    r.passes = 10;
    return r;
}

// The defaults take a second for a variance of 1.
std::vector<SettingResult> results() {
    return {result({}, 1, 1), result({{"max-depth", 4u}}, 0.5, 1, 0.05), result({{"guide-share", 0.75}}, 1, 0.5),
            result({{"guide-share", 0.25}}, 1, 0.8), result({{"sampler", "independent"}}, 1.2, 4), result({{"spp-gradient", 16u}}, 3, 0.3)};
}

TEST(Tradeoff, FrontierIsWhatNothingBeats) {
    EXPECT_EQ(frontier(results()), (std::vector<std::size_t>{1, 2, 5}));
    std::vector<SettingResult> unknown = results();
    unknown[2].relativeVariance.value = std::nan("");
    EXPECT_EQ(frontier(unknown), (std::vector<std::size_t>{1, 3, 5}));
}

TEST(Tradeoff, BiasCountsForMoreTheLongerARunIs) {
    const auto r = results();
    EXPECT_NEAR(advantage(r[1], r[0], 1), (1 - 0.0025) / 0.5, 1e-9); // twice as fast, and hardly biased yet
    EXPECT_NEAR(advantage(r[1], r[0], 100), 100 * (0.01 - 0.0025) / 0.5, 1e-9);
    EXPECT_EQ(advantage(r[1], r[0], 1000), 0); // its bias is more than the error of the defaults
    EXPECT_NEAR(advantage(r[2], r[0], 1000), 2, 1e-9);
    EXPECT_NEAR(r[1].errorAfter(1000), std::sqrt(0.0025 + 0.0005), 1e-9);
    const auto best = bestChanges(r, 100, 4);
    ASSERT_EQ(best.size(), 3u); // the sampler is worse and beaten
    EXPECT_EQ(best[0].text(), "--guide-share 0.75");
    EXPECT_EQ(best[1].text(), "--max-depth 4");
    EXPECT_EQ(best[2].text(), "--spp-gradient 16"); // slower and on the frontier
    EXPECT_EQ(bestChanges(r, 100, 1).size(), 1u);
}

TEST(Tradeoff, ReportsSayWhatIsMissed) {
    TradeoffReport report;
    report.singles = results();
    report.combined = {result({}, 1, 1), result({{"max-depth", 4u}}, 0.5, 1), result({{"guide-share", 0.75}}, 1, 0.5),
                       result({{"max-depth", 4u}, {"guide-share", 0.75}}, 0.5, 0.4)};
    report.reference.reference.values = {1};
    const std::string csv = tradeoffCsv(report);
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 6 + 4);
    EXPECT_EQ(csv.rfind(kTradeoffColumns, 0), 0u);
    const std::string text = tradeoffMarkdown(report);
    EXPECT_NE(text.find("--guide-share 0.75: 2.5 times the time when left out"), std::string::npos) << text; // 5 against 2
    EXPECT_NE(text.find("--max-depth 4: 2.5 times the time when left out"), std::string::npos) << text;
    EXPECT_NE(text.find("the default of --sampler: 4.8 times the time with the best other value"), std::string::npos) << text;
    // What has one part is left out once.
    TradeoffReport single = report;
    single.combined.resize(3);
    const std::string once = tradeoffMarkdown(single);
    EXPECT_NE(once.find("- --max-depth 4: 2 times the time when left out\n"), std::string::npos) << once;
    EXPECT_EQ(once.find("when left out of"), std::string::npos) << once;
    const ParetoPlot plot = tradeoffPlot(report);
    EXPECT_EQ(plot.points.size(), 7u); // single changes are there once
    const std::string svg = plot.svg();
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_NE(svg.find("<title>" + plot.title), std::string::npos);
    const Image png = plot.png();
    EXPECT_GT(png.width, 400);
    EXPECT_TRUE(ParetoPlot{}.frontier.empty());
    EXPECT_EQ(ParetoPlot{}.svg().find("nan"), std::string::npos);
}

// Of as many changes as are combined.
TEST(Tradeoff, ReportsSayWhatEachOfFourCosts) {
    const std::vector<KnobChange> best = {{"max-depth", 4u}, {"guide-share", 0.75}, {"spp-gradient", 16u}, {"sampler", "independent"}};
    TradeoffReport report;
    report.singles = results();
    report.combined = {result({}, 1, 1)};
    for (const Setting& s : combinedSettings(tradeoffOptions(), best))
        report.combined.push_back(result(s.changes, 1, std::pow(0.5, double(s.changes.size())))); // each halves the variance
    report.reference.reference.values = {1};
    const std::string text = tradeoffMarkdown(report);
    for (const KnobChange& change : best)
        EXPECT_NE(text.find("- " + change.text() + ": 2 times the time when left out of --max-depth 4 "), std::string::npos) << text;
}

TEST(Tradeoff, PartsHaveRandomNumbersOfTheirOwn) {
    const test::TemporaryFolder folder;
    writeExr(folder / "target.exr", Image(12, 12, 3, 0));
    const Options base = test::parse({"tradeoff", CMPG_SOURCE_DIR "/scenes/box/scene.gltf", "--param", "white.baseColor", "--target", folder / "target.exr",
                                      "--spp", "4", "--max-depth", "3", "--sampling", "bsdf", "--roulette", "off", "-o", folder / "out"});
    Report report(base);
    CompareSubject subject(base, report);
    subject.steps = true;
    const auto variance = [&](std::uint32_t part) {
        subject.part = part;
        const TradeoffBudget budget{.seconds = 0, .turns = 2, .passes = 4, .referenceSeconds = 0};
        return measureSettings(subject, {makeSetting(base, {})}, budget, Reference{{1, 1, 1}, {}, 0}, report, {}).results.front().relativeVariance.value;
    };
    const double first = variance(0);
    EXPECT_GT(first, 0);
    EXPECT_EQ(variance(0), first);
    EXPECT_NE(variance(1), first);
}

TEST(TradeoffProgram, MeasuresEveryKnob) {
    const test::TemporaryFolder folder;
    const std::string box = CMPG_SOURCE_DIR "/scenes/box/scene.gltf";
    writeExr(folder / "target.exr", Image(12, 12, 3, 0)); // far from the image: the gradient is no noise, and several changes are worth combining
    const auto run = runProgram({"tradeoff", box, "--headless", "--json", "--param", "white.baseColor", "--target", folder / "target.exr", "--spp", "4",
                                 "--max-depth", "3", "--train", "2", "--time", "0.1s", "--seeds", "2", "--sampling", "bsdf", "--roulette", "off", "-o",
                                 folder / "out"});
    ASSERT_EQ(run.code, 0) << run.err;
    const auto json = nlohmann::json::parse(run.out);
    for (const auto& [name, path] : json.at("outputs").items())
        EXPECT_TRUE(std::filesystem::exists(path.get<std::string>())) << name;
    std::set<std::string> settings;
    std::map<std::string, nlohmann::json> singles;
    for (const auto& row : json.at("table")) {
        settings.insert(row.at("setting"));
        if (row.at("part") == "single") {
            singles[row.at("setting")] = row;
        } else if (singles.contains(row.at("setting"))) {
            const auto& before = singles[row.at("setting")]; // in so little time of as many passes, but by other random numbers
            EXPECT_TRUE(row.at("passes") != before.at("passes") || row.at("relative_variance") != before.at("relative_variance")) << row;
        }
        EXPECT_GE(row.at("passes"), 8);
        EXPECT_GT(row.at("seconds_per_pass"), 0);
    }
    for (const char* expected : {"defaults", "--spp 16", "--max-depth 6", "--sampling conditional", "--sampler independent", "--no-nee"})
        EXPECT_TRUE(settings.contains(expected)) << expected;
    EXPECT_FALSE(settings.contains("--guide-share 0.75")); // nothing is guided
    EXPECT_NE(readText(folder / "out/report.html").find("speed against accuracy"), std::string::npos);
    EXPECT_EQ(runProgram({"tradeoff", box, "--headless", "-o", folder / "none"}).code, 2);
}

} // namespace
} // namespace cmpg

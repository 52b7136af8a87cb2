// Optimisations that end before their time: killed, out of disk, out of device. What they were going to find is found all the same, bit for bit.
#include "command_line.h"
#include "optimize/checkpoint_file.h"
#include "scene/image.h"

#include <chrono>
#include <csignal>
#include <fstream>
#include <gtest/gtest.h>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <sys/resource.h>
#include <thread>

namespace cmpg {
namespace {

namespace fs = std::filesystem;
using test::ProgramResult;
using test::runProgram;
using test::RunningProgram;

using Arguments = std::vector<std::string>;
using Files = std::map<std::string, std::string>; // contents by name

// A run with all that has a state: guide, automatic choice, roulette, light distributions that follow a parameter, Adam, a schedule.
class Resume : public testing::Test {
  protected:
    static constexpr std::uint32_t kSteps = 20;

    void SetUp() override { writeExr(folder_ / "target.exr", Image(40, 32, 3, 0.5f)); }

    Arguments command(const std::string& run, const Arguments& more = {}, std::uint32_t steps = kSteps) const {
        Arguments all = {"optimize", CMPG_SOURCE_DIR "/scenes/box/scene.gltf", "--param", "painting.baseColor", "--param", "light.emission", "--target",
                         folder_ / "target.exr", "--spp", "2", "--spp-gradient", "2", "--steps", std::to_string(steps), "--schedule", "cosine",
                         "--quiet", "--headless", "-o", folder_ / run, "--save-guide", folder_ / (run + "/learned.guide")};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }

    // What a run found: exact values, gradients of the last step, pictures, the guide; and the losses on the way, without the seconds.
    Files results(const std::string& run) const {
        Files files;
        for (const char* name : {"parameters/painting.baseColor.exr", "parameters/light.emission.exr", "gradients/painting.baseColor.exr", "final.exr",
                                 "difference.exr", "learned.guide"})
            files[name] = test::readText(folder_ / (run + "/" + name));
        std::istringstream csv(test::readText(folder_ / (run + "/loss.csv")));
        for (std::string line; std::getline(csv, line);) {
            std::istringstream row(line);
            std::string field;
            for (int column = 0; std::getline(row, field, ','); ++column)
                if (column < 5 || column > 7)
                    files["loss.csv"] += field + ",";
            files["loss.csv"] += "\n";
        }
        return files;
    }

    void expectSame(const Files& found, const Files& expected, const std::string& what) const {
        for (const auto& [name, content] : expected) {
            EXPECT_FALSE(content.empty()) << name;
            EXPECT_TRUE(found.at(name) == content) << what << ": " << name << " differs";
        }
    }

    // Of a run that nothing disturbs and that keeps no checkpoints.
    Files uninterrupted() const {
        const ProgramResult result = runProgram(command("whole", {"--checkpoint-every", "0"}));
        EXPECT_EQ(result.code, 0) << result.err;
        EXPECT_FALSE(fs::exists(checkpointFiles(folder_ / "whole")[0]));
        return results("whole");
    }

    // Of the first such run: all have the same arguments but for the folder.
    const Files& expected() const {
        static const Files found = uninterrupted();
        return found;
    }

    // Rows of loss.csv so far.
    std::size_t rows(const std::string& run) const {
        std::ifstream csv(folder_ / (run + "/loss.csv"));
        std::size_t count = 0;
        for (std::string line; std::getline(csv, line);)
            ++count;
        return count > 0 ? count - 1 : 0;
    }

    bool waitForRows(RunningProgram& program, const std::string& run, std::size_t count) const {
        while (program.running() && rows(run) < count)
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        return rows(run) >= count;
    }

    // The events of a run's log: each line is an object of its own with time, level, step and event.
    std::vector<nlohmann::json> events(const std::string& run, const std::string& name = "") const {
        std::vector<nlohmann::json> found;
        std::ifstream log(folder_ / (run + "/log.jsonl"));
        for (std::string line; std::getline(log, line);) {
            const auto event = nlohmann::json::parse(line);
            for (const char* key : {"time", "level", "step", "event", "text"})
                EXPECT_TRUE(event.contains(key)) << line;
            if (name.empty() || event["event"] == name)
                found.push_back(event);
        }
        return found;
    }

    void killAndResume(int kills);
    void loseDevices(const std::string& staging, std::initializer_list<double> shares);

    const test::TemporaryFolder folder_;
};

// Moments are uniform over the time that a whole run takes, from the start of the process to its end: loading, compiling, steps, checkpoints,
// the writing of results. A run that ends by itself is followed by a new one.
void Resume::killAndResume(int kills) {
    uninterrupted(); // kernels are in the driver's cache from here on
    const auto begin = std::chrono::steady_clock::now();
    const Files expected = uninterrupted();
    const auto since = [](auto moment) { return std::chrono::duration<double>(std::chrono::steady_clock::now() - moment).count(); };
    const double seconds = since(begin);
    std::mt19937 random(11);
    double latest = seconds;
    int survived = 0, amidst = 0, finished = 0;
    // On some machines a few moments miss all of the steps, which are a part of the time.
    const auto goesOn = [&] { return survived < kills || (amidst < kills / 5 && survived < 10 * kills); };
    for (int run = 0; goesOn(); ++run) {
        const std::string name = "run" + std::to_string(run);
        const Arguments arguments = command(name, {"--checkpoint-every", "1", "--resume", folder_ / name});
        for (bool done = false; !done;) {
            const bool whole = !fs::exists(folder_ / name);
            const auto started = std::chrono::steady_clock::now();
            RunningProgram program(arguments, folder_ / "output");
            if (goesOn()) {
                const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(std::uniform_real_distribution<double>(0, latest)(random));
                while (program.running() && std::chrono::steady_clock::now() < until)
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
            if (goesOn() && program.running())
                program.kill(SIGKILL);
            const ProgramResult result = program.wait();
            const bool killed = result.code == 128 + SIGKILL; // it may have ended just before
            ASSERT_TRUE(killed || result.code == 0) << result.code << "\n" << result.err;
            if (killed && ++survived % 20 == 0)
                std::cout << survived << " kills" << std::endl;
            if (killed && rows(name) == 0)
                latest *= 1.1; // the machine has become slower
            if (!killed && whole)
                latest = since(started); // or faster
            amidst += killed && rows(name) > 0 && rows(name) < kSteps;
            done = !killed;
        }
        ++finished;
        expectSame(results(name), expected, name);
        fs::remove_all(folder_ / name);
    }
    EXPECT_GE(amidst, kills / 5); // else the moments were badly chosen
    std::cout << survived << " kills, " << amidst << " of them between two steps, in " << finished << " runs of " << seconds << " s\n";
}

TEST_F(Resume, SurvivesKills) { killAndResume(5); }
TEST_F(Resume, FullSurvivesKills) { killAndResume(200); }

TEST_F(Resume, AnInterruptedRunGoesOnFromItsFolderAlone) {
    {
        RunningProgram program(command("run", {"--checkpoint-every", "1h"}), folder_ / "output");
        ASSERT_TRUE(waitForRows(program, "run", 5));
        program.kill(SIGINT); // which waits for the step in flight, and keeps a checkpoint whatever the interval
        EXPECT_EQ(program.wait().code, 130);
    }
    const std::size_t done = rows("run");
    ASSERT_LT(done, std::size_t(kSteps));
    const auto result = runProgram({"optimize", "--resume", folder_ / "run"});
    EXPECT_EQ(result.code, 0) << result.err;
    expectSame(results("run"), expected(), "resumed");
    const auto resumed = events("run", "resume");
    ASSERT_EQ(resumed.size(), 1u);
    EXPECT_EQ(resumed[0]["step"], done);
    EXPECT_EQ(events("run", "finished").at(0)["step"], kSteps);
    // Once more: nothing is left to do but to write the results again.
    for (const char* name : {"final.exr", "loss.csv", "parameters/painting.baseColor.exr"})
        fs::remove(folder_ / ("run/" + std::string(name)));
    const auto again = runProgram(command("run", {"--resume", folder_ / "run"}));
    EXPECT_EQ(again.code, 0) << again.err;
    expectSame(results("run"), expected(), "finished");
}

// Without --resume a folder gets another run; what the earlier one left is no part of it.
TEST_F(Resume, AnEarlierRunInTheFolderIsNotContinued) {
    ASSERT_EQ(runProgram(command("run", {}, 2)).code, 0);
    const std::string earlier = test::readText(checkpointFiles(folder_ / "run")[0]);
    const auto other = runProgram(command("run", {"--checkpoint-every", "0"}, 1));
    EXPECT_EQ(other.code, 0) << other.err;
    EXPECT_NE(other.err.find("checkpoint.replaced.bin"), std::string::npos) << other.err;
    EXPECT_TRUE(test::readText(folder_ / "run/checkpoint.replaced.bin") == earlier);
    const auto resumed = runProgram({"optimize", "--resume", folder_ / "run"});
    EXPECT_EQ(resumed.code, 2) << resumed.err; // the run kept none
    EXPECT_EQ(rows("run"), 1u);
}

TEST_F(Resume, BeginsAtStepZeroWhereThereIsNoCheckpoint) {
    const auto result = runProgram(command("run", {"--resume", folder_ / "run"}, 2));
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.err.find("has no checkpoint"), std::string::npos) << result.err;
    EXPECT_EQ(rows("run"), 2u);
    const auto alone = runProgram({"optimize", "--resume", folder_ / "nothing"});
    EXPECT_EQ(alone.code, 2) << alone.err; // no scene is named anywhere
}

TEST_F(Resume, RefusesAnotherRunByName) {
    ASSERT_EQ(runProgram(command("run", {"--checkpoint-every", "1"}, 3)).code, 0);
    const std::string painted = folder_ / "target2.exr";
    writeExr(painted, Image(40, 32, 3, 0.25f));
    struct Case {
        Arguments more;
        int code;
        std::string says;
    };
    const std::vector<Case> cases = {
        {{"--loss", "l1"}, 2, "--loss"},
        {{"--seed", "7"}, 2, "--seed"},
        {{"--rate", "0.5"}, 2, "--rate"},
        {{"--optimizer", "sgd"}, 2, "--optimizer"},
        {{"--max-depth", "3"}, 2, "--max-depth"},
        {{"--sampling", "bsdf"}, 2, "--sampling"},
        {{"--set", "painting.baseColor=0.1"}, 3, "the start of painting.baseColor"},
        {{"--set", "white.baseColor=0.1"}, 3, "the scene's materials"},
        {{"--camera", "corner"}, 3, "the camera"},
        {{"--filter", "tent"}, 2, "filter differs: it has none, this one tent:1"},
    };
    for (const Case& c : cases) {
        Arguments more = {"--resume", folder_ / "run"};
        more.insert(more.end(), c.more.begin(), c.more.end());
        const auto result = runProgram(command("run", more, 3));
        EXPECT_EQ(result.code, c.code) << c.says << "\n" << result.err;
        EXPECT_NE(result.err.find(c.says), std::string::npos) << result.err;
    }
    // Under a schedule, later steps depend on their number.
    const auto longer = runProgram(command("run", {"--resume", folder_ / "run"}, 4));
    EXPECT_EQ(longer.code, 2);
    EXPECT_NE(longer.err.find("--steps"), std::string::npos) << longer.err;
    Arguments other = command("run", {"--resume", folder_ / "run"}, 3);
    *std::find(other.begin(), other.end(), folder_ / "target.exr") = painted;
    EXPECT_EQ(runProgram(other).code, 3);
    EXPECT_EQ(runProgram(command("elsewhere", {"--resume", folder_ / "run"})).code, 2); // two folders
    // What does not matter may differ.
    const auto same = runProgram(command("run", {"--resume", folder_ / "run", "--memory", "64", "--checkpoint-every", "5s"}, 3));
    EXPECT_EQ(same.code, 0) << same.err;
}

TEST_F(Resume, GoesOnFromTheOlderCheckpointWhereTheNewestIsDamaged) {
    {
        RunningProgram program(command("run", {"--checkpoint-every", "2"}), folder_ / "output");
        ASSERT_TRUE(waitForRows(program, "run", 9));
        program.kill(SIGKILL);
        program.wait();
    }
    const fs::path newest = checkpointFiles(folder_ / "run")[0];
    ASSERT_TRUE(fs::exists(newest));
    {
        std::fstream file(newest, std::ios::in | std::ios::out | std::ios::binary);
        const auto middle = std::streamoff(fs::file_size(newest) / 2);
        file.seekg(middle);
        const char byte = char(file.get() ^ 1);
        file.seekp(middle);
        file.put(byte);
    }
    const auto result = runProgram(command("run", {"--checkpoint-every", "2", "--resume", folder_ / "run"}));
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.err.find("is damaged"), std::string::npos) << result.err;
    expectSame(results("run"), expected(), "resumed");
    for (const fs::path& file : checkpointFiles(folder_ / "run"))
        test::writeText(file, "nothing of use");
    const auto refused = runProgram(command("run", {"--resume", folder_ / "run"}));
    EXPECT_EQ(refused.code, 3) << refused.err;
    EXPECT_NE(refused.err.find("no checkpoint"), std::string::npos) << refused.err;
}

// Files of more than some bytes fail to grow from then on, as they do where a disk is full.
TEST_F(Resume, ADiskWithoutRoomIsSurvived) {
    for (const bool freed : {true, false}) {
        const std::string name = freed ? "freed" : "full";
        RunningProgram program(command(name, {"--checkpoint-every", "1"}), folder_ / "output", {}, [] { std::signal(SIGXFSZ, SIG_IGN); });
        const auto limit = [&](rlim_t bytes) {
            const rlimit both{bytes, RLIM_INFINITY};
            ASSERT_EQ(prlimit(program.pid(), RLIMIT_FSIZE, &both, nullptr), 0);
        };
        ASSERT_TRUE(waitForRows(program, name, 3));
        limit(0);
        if (freed) {
            std::this_thread::sleep_for(std::chrono::milliseconds(300));
            limit(RLIM_INFINITY);
        }
        const ProgramResult result = program.wait();
        EXPECT_TRUE(result.code == 6 || (freed && result.code == 0)) << result.code << "\n" << result.err;
        // With its output cut off, a run that found no room says so by its code alone.
        std::vector<std::string> refused;
        ASSERT_TRUE(fs::exists(checkpointFiles(folder_ / name)[0]));
        const auto resumed = runProgram(command(name, {"--resume", folder_ / name}));
        EXPECT_EQ(resumed.code, 0) << resumed.err;
        expectSame(results(name), expected(), name);
    }
}

TEST_F(Resume, AFolderThatVanishesIsMadeAgain) {
    RunningProgram program(command("run", {"--checkpoint-every", "3"}), folder_ / "output");
    ASSERT_TRUE(waitForRows(program, "run", 4));
    fs::rename(folder_ / "run", folder_ / "gone");
    const ProgramResult result = program.wait();
    EXPECT_NE(result.err.find("continues in memory"), std::string::npos) << result.err;
    Files found = results("run");
    for (const char* name : {"parameters/painting.baseColor.exr", "final.exr", "loss.csv", "learned.guide"})
        EXPECT_TRUE(found[name] == expected().at(name)) << name;
    EXPECT_TRUE(fs::exists(checkpointFiles(folder_ / "run")[0]));
}

// Permissions do not bind everybody, a file where the folder was does.
TEST_F(Resume, AFolderThatTakesNothingMoreIsSurvived) {
    RunningProgram program(command("run", {"--checkpoint-every", "1"}), folder_ / "output");
    ASSERT_TRUE(waitForRows(program, "run", 4));
    fs::rename(folder_ / "run", folder_ / "kept");
    test::writeText(folder_ / "run", "in the way");
    const ProgramResult result = program.wait();
    EXPECT_EQ(result.code, 6) << result.err;
    EXPECT_NE(result.err.find("continues in memory"), std::string::npos) << result.err;
    EXPECT_EQ(test::readText(folder_ / "run"), "in the way");
    fs::remove(folder_ / "run");
    fs::rename(folder_ / "kept", folder_ / "run");
    const auto resumed = runProgram(command("run", {"--resume", folder_ / "run"}));
    EXPECT_EQ(resumed.code, 0) << resumed.err;
    expectSame(results("run"), expected(), "resumed");
}

// Submissions are counted: so many succeed. One after another is the last, in pictures, passes and, where those are submissions, transfers.
void Resume::loseDevices(const std::string& staging, std::initializer_list<double> shares) {
    const auto run = [&](int submissions) {
        fs::remove_all(folder_ / "run");
        return runProgram(command("run", {"--checkpoint-every", "1h"}), {"CMPG_FAULT=lost:" + std::to_string(submissions), "CMPG_STAGING=" + staging});
    };
    int enough = 256;
    while (run(enough).code != 0)
        ASSERT_LT(enough *= 2, 1 << 20);
    int amidst = 0;
    for (const double share : shares) {
        const auto lost = run(int(share * enough));
        ASSERT_EQ(lost.code, 4) << lost.err;
        EXPECT_NE(lost.err.find("the device was lost"), std::string::npos) << lost.err;
        if (!fs::exists(checkpointFiles(folder_ / "run")[0]))
            continue; // lost before the first step
        ++amidst;
        EXPECT_NE(lost.err.find("--resume"), std::string::npos) << lost.err;
        EXPECT_FALSE(test::readText(folder_ / "run/parameters/painting.baseColor.exr").empty());
        const auto resumed = runProgram(command("run", {"--resume", folder_ / "run"}));
        ASSERT_EQ(resumed.code, 0) << resumed.err;
        expectSame(results("run"), expected(), std::to_string(share * enough) + " submissions");
    }
    EXPECT_GE(5 * amidst, 3 * int(shares.size()));
}

TEST_F(Resume, ALostDeviceLeavesACheckpoint) { loseDevices("1", {0.5, 0.47, 0.4}); }
TEST_F(Resume, FullALostDeviceLeavesACheckpointWithoutTransfers) { loseDevices("0", {0.5, 0.49, 0.47, 0.43, 0.35}); }

// Device memory of every size between nothing and enough: what does not suffice is said before the first step.
TEST_F(Resume, TooLittleMemoryIsSaidBeforeTheFirstStep) {
    const Arguments arguments = command("run", {"--json", "--memory", "32"}, 8);
    const auto whole = runProgram(arguments);
    ASSERT_EQ(whole.code, 0) << whole.err;
    const auto peak = nlohmann::json::parse(whole.out)["memory"]["device_peak_bytes"].get<std::uint64_t>();
    for (const double share : {0.0, 0.02, 0.3, 0.6, 0.9, 0.99, 1.0}) {
        fs::remove_all(folder_ / "run");
        const auto limited = runProgram(arguments, {"CMPG_FAULT=memory:" + std::to_string(std::uint64_t(share * double(peak)))});
        if (share == 1.0) {
            EXPECT_EQ(limited.code, 0) << limited.err;
            continue;
        }
        EXPECT_EQ(limited.code, 4) << share << "\n" << limited.err;
        EXPECT_NE(limited.err.find("cannot allocate"), std::string::npos) << limited.err;
        EXPECT_EQ(rows("run"), 0u) << share;
    }
}

} // namespace
} // namespace cmpg

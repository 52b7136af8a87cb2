// Checkpoints: what goes in comes out, what is damaged is refused, and a run that goes on from one is the run that never ended.
#include "base/error.h"
#include "linear_model.h"
#include "optimize/checkpoint.h"
#include "support/temp_folder.h"

#include <fstream>
#include <iostream>
#include <gtest/gtest.h>
#include <zlib.h>

namespace cmpg {
namespace {

namespace fs = std::filesystem;
using test::LinearModel;

class CheckpointFiles : public testing::Test {
  protected:
    const test::TempFolder temporary_;
    const fs::path folder_ = temporary_ / "run"; // is not there yet
};

OptimizeConfig makeConfig(OptimizerKind kind = OptimizerKind::Adam) {
    OptimizeConfig config;
    config.steps = 20;
    config.optimizer.kind = kind;
    config.optimizer.schedule = Schedule::Cosine;
    config.targets = test::makeTargets(2, 6, 4);
    return config;
}

struct Bench {
    explicit Bench(const OptimizeConfig& c = makeConfig(), Scene of = test::makeScene()) : scene(std::move(of)), model(scene, 2, 6, 4, 0.1), run(model, scene, c, {0, 1}) {}
    std::vector<FileSection> sections() const { return checkpointSections(run, model, {{"--loss", "\"mse\""}}, "{}", "a device"); }
    void advance(std::uint32_t steps) {
        while (steps-- > 0)
            run.step();
    }

    Scene scene;
    LinearModel model;
    Optimization run;
};

Bytes smallFile(std::uint32_t steps = 3) {
    Bench bench;
    bench.advance(steps);
    return joinSections(bench.sections());
}

std::optional<ErrorKind> refusalOf(std::span<const std::uint8_t> bytes) {
    try {
        readCheckpoint(parseSections(bytes));
        return std::nullopt;
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()), "");
        return error.kind;
    }
}

TEST_F(CheckpointFiles, ARunGoesOnAsIfItHadNotEnded) {
    std::vector<OptimizeConfig> configs = {makeConfig(OptimizerKind::Auto), makeConfig(OptimizerKind::Adam), makeConfig(OptimizerKind::Sgd)};
    configs.push_back(makeConfig(OptimizerKind::Auto)); // images of the values of several steps
    configs.back().viewsPerStep = 1;
    configs.push_back(configs.back()); // and some that begin anew
    configs.back().imageBytes = 0;
    for (const OptimizeConfig& config : configs) {
        Bench whole(config);
        whole.advance(20);
        for (const std::uint32_t at : {1u, 7u, 19u, 20u}) {
            Bench first(config);
            first.advance(at);
            writeCheckpointFile(folder_, first.sections());
            std::vector<std::string> refused;
            const auto checkpoint = findCheckpoint(folder_, refused);
            ASSERT_TRUE(checkpoint && refused.empty());
            EXPECT_EQ(checkpoint->madeWith, "a device");
            Bench second(config);
            resume(*checkpoint, second.run, second.model);
            ASSERT_EQ(second.run.state().step, at);
            second.advance(20 - at);
            for (std::size_t p = 0; p < 2; ++p)
                EXPECT_EQ(second.scene.parameters[p].values, whole.scene.parameters[p].values) << at;
            EXPECT_EQ(second.run.gradients(), whole.run.gradients()) << at;
            ASSERT_EQ(second.run.state().history.size(), 20u);
            for (std::size_t i = 0; i < 20; ++i)
                EXPECT_EQ(second.run.state().history[i].loss, whole.run.state().history[i].loss) << at;
        }
    }
}

// Maps of one material, which step together.
Scene makeMaps() {
    Scene scene;
    scene.parameters.push_back(test::makeParameter("wall.baseColor", SlotKind::BaseColor, 4, 4, 3, 0.5f));
    scene.parameters.push_back(test::makeParameter("wall.specular", SlotKind::Specular, 4, 4, 3, 0.5f));
    Material& material = scene.materials.emplace_back();
    material.parameters[std::size_t(SlotKind::BaseColor)] = 0;
    material.parameters[std::size_t(SlotKind::Specular)] = 1;
    return scene;
}

TEST_F(CheckpointFiles, MapsThatStepTogetherGoOnAsWell) {
    const OptimizeConfig config = makeConfig(OptimizerKind::Auto);
    Bench whole(config, makeMaps()), first(config, makeMaps()), second(config, makeMaps());
    whole.advance(12);
    first.advance(5);
    ASSERT_EQ(first.run.state().cross.size(), 1u);
    ASSERT_EQ(first.run.state().cross[0].below.size(), 16u * 15);
    writeCheckpointFile(folder_, first.sections());
    std::vector<std::string> refused;
    const auto checkpoint = findCheckpoint(folder_, refused);
    ASSERT_TRUE(checkpoint && refused.empty());
    resume(*checkpoint, second.run, second.model);
    second.advance(7);
    for (std::size_t p = 0; p < 2; ++p)
        EXPECT_EQ(second.scene.parameters[p].values, whole.scene.parameters[p].values);
    Bench apart(config); // another scene
    EXPECT_THROW(resume(*checkpoint, apart.run, apart.model), Error);
    Checkpoint damaged = *checkpoint;
    damaged.state.cross[0].below.pop_back();
    EXPECT_THROW(resume(damaged, second.run, second.model), Error);
}

TEST(Checkpoint, EveryTruncationIsRefused) {
    const Bytes file = smallFile();
    ASSERT_EQ(refusalOf(file), std::nullopt);
    for (std::size_t length = 0; length < file.size(); ++length)
        ASSERT_EQ(refusalOf(std::span(file).first(length)), ErrorKind::Input) << length << " of " << file.size();
    Bytes longer = file;
    longer.push_back(0);
    EXPECT_EQ(refusalOf(longer), ErrorKind::Input);
}

TEST(Checkpoint, EveryFlippedBitIsRefused) {
    Bytes file = smallFile();
    for (std::size_t bit = 0; bit < 8 * file.size(); ++bit) {
        file[bit / 8] ^= std::uint8_t(1u << bit % 8);
        ASSERT_EQ(refusalOf(file), ErrorKind::Input) << "bit " << bit;
        file[bit / 8] ^= std::uint8_t(1u << bit % 8);
    }
    EXPECT_EQ(refusalOf(file), std::nullopt);
    std::cout << 8 * file.size() << " bits\n";
}

// Several bits at once, runs of zeros and of ones: what a bad sector or a stray write leaves.
TEST(Checkpoint, RandomDamageIsRefused) {
    const Bytes file = smallFile();
    std::mt19937 random(5);
    for (int i = 0; i < 20000; ++i) {
        Bytes damaged = file;
        const std::size_t begin = random() % file.size(), length = 1 + random() % std::min<std::size_t>(512, file.size() - begin);
        for (std::size_t k = begin; k < begin + length; ++k)
            damaged[k] = i % 3 == 0 ? 0 : i % 3 == 1 ? 0xff : std::uint8_t(random());
        if (damaged != file) {
            ASSERT_EQ(refusalOf(damaged), ErrorKind::Input) << i;
        }
    }
}

// A file whose checksums are right is read or refused, and nothing else, whatever its contents say.
TEST(Checkpoint, WrongContentsUnderRightChecksums) {
    Bench bench;
    bench.advance(3);
    std::mt19937 random(6);
    std::size_t read = 0, applied = 0;
    for (int i = 0; i < 20000; ++i) {
        std::vector<FileSection> sections = bench.sections();
        FileSection& section = sections[random() % sections.size()];
        if (!section.bytes.empty())
            for (int k = 0; k < 1 + i % 4; ++k)
                section.bytes[random() % section.bytes.size()] = std::uint8_t(random());
        if (i % 16 == 0)
            section.bytes.resize(random() % (section.bytes.size() + 8));
        if (i % 64 == 1)
            section.name = "other";
        try {
            const Checkpoint checkpoint = readCheckpoint(parseSections(joinSections(sections)));
            ++read;
            Bench other;
            resume(checkpoint, other.run, other.model);
            ++applied;
        } catch (const Error& error) {
            ASSERT_EQ(error.kind, ErrorKind::Input);
        }
    }
    EXPECT_GT(read, 1000u); // values alone may be anything
    EXPECT_GT(applied, 1000u);
    EXPECT_LT(applied, 19000u);
}

TEST_F(CheckpointFiles, TheOneBeforeIsUsedWhereTheNewestIsDamaged) {
    Bench bench;
    bench.advance(2);
    writeCheckpointFile(folder_, bench.sections());
    bench.advance(1);
    writeCheckpointFile(folder_, bench.sections());
    const fs::path newest = checkpointFiles(folder_)[0];
    std::vector<std::string> refused;
    EXPECT_EQ(findCheckpoint(folder_, refused)->state.step, 3u);
    EXPECT_TRUE(refused.empty());
    fs::resize_file(newest, fs::file_size(newest) - 1);
    EXPECT_EQ(findCheckpoint(folder_, refused)->state.step, 2u);
    ASSERT_EQ(refused.size(), 1u);
    EXPECT_NE(refused[0].find("truncated"), std::string::npos) << refused[0];
    // Killed between the two renames: nothing has the newest one's name.
    fs::remove(newest);
    refused.clear();
    EXPECT_EQ(findCheckpoint(folder_, refused)->state.step, 2u);
    EXPECT_TRUE(refused.empty());
}

TEST_F(CheckpointFiles, ACompleteFileThatWasNotNamedYetCounts) {
    Bench bench;
    bench.advance(2);
    writeCheckpointFile(folder_, bench.sections());
    fs::rename(checkpointFiles(folder_)[0], checkpointFiles(folder_)[2]);
    std::vector<std::string> refused;
    EXPECT_EQ(findCheckpoint(folder_, refused)->state.step, 2u);
}

// Larger than any memory: what is no checkpoint is not read, and what may be one does not fit.
TEST_F(CheckpointFiles, HugeFilesAreRefused) {
    const fs::path file = checkpointFiles(folder_)[0];
    fs::create_directories(folder_);
    for (const bool begins : {false, true}) {
        Bytes start = smallFile();
        if (!begins)
            std::fill(start.begin(), start.end(), std::uint8_t(0));
#ifdef __SANITIZE_ADDRESS__ // which ends the program where others throw
        else
            continue;
#endif
        writeFile(file, start);
        fs::resize_file(file, std::uintmax_t(1) << 43); // without blocks on the disk
        std::vector<std::string> refused;
        EXPECT_FALSE(findCheckpoint(folder_, refused));
        ASSERT_EQ(refused.size(), 1u);
        EXPECT_NE(refused[0].find(begins ? "does not fit into memory" : "it is no checkpoint"), std::string::npos) << refused[0];
    }
}

// Another run begins in the folder: the newest is kept under another name, and none is found.
TEST_F(CheckpointFiles, ThoseOfAnEarlierRunAreSetAside) {
    EXPECT_TRUE(setCheckpointsAside(folder_).empty());
    Bench bench;
    for (int steps = 0; steps < 2; ++steps) {
        bench.advance(1);
        writeCheckpointFile(folder_, bench.sections());
    }
    const Bytes newest = readFile(checkpointFiles(folder_)[0]);
    const fs::path aside = setCheckpointsAside(folder_);
    EXPECT_EQ(readFile(aside), newest);
    std::vector<std::string> refused;
    EXPECT_FALSE(findCheckpoint(folder_, refused));
    EXPECT_TRUE(refused.empty());
    bench.advance(1);
    writeCheckpointFile(folder_, bench.sections());
    EXPECT_EQ(setCheckpointsAside(folder_), aside); // in place of the older one
    EXPECT_NE(readFile(aside), newest);
}

TEST_F(CheckpointFiles, OtherVersionsAndFilesAreNamed) {
    Bytes file = smallFile();
    file[8] = 99;
    const auto sum = std::uint32_t(crc32(0, file.data(), 16));
    std::memcpy(&file[16], &sum, 4);
    try {
        parseSections(file);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("version 99"), std::string::npos) << error.what();
    }
    const char text[] = "loss,step\n1,2\n, a text of some length";
    EXPECT_EQ(refusalOf(std::span(reinterpret_cast<const std::uint8_t*>(text), sizeof text)), ErrorKind::Input);
    EXPECT_EQ(refusalOf({}), ErrorKind::Input);
}

TEST_F(CheckpointFiles, WritingWhereNothingCanBeWrittenKeepsWhatThereIs) {
    Bench bench;
    bench.advance(2);
    std::ofstream(folder_) << "a file where the folder should be";
    EXPECT_THROW(writeCheckpointFile(folder_ / "run", bench.sections()), Error);
    fs::remove(folder_);
    writeCheckpointFile(folder_, bench.sections());
    // A folder in the way of the aside name: nothing can be written, and the old one stays.
    fs::create_directories(checkpointFiles(folder_)[2] / "in the way");
    EXPECT_THROW(writeCheckpointFile(folder_, bench.sections()), Error);
    std::vector<std::string> refused;
    EXPECT_EQ(findCheckpoint(folder_, refused)->state.step, 2u);
    // A folder that vanished is made again.
    fs::remove_all(folder_);
    writeCheckpointFile(folder_, bench.sections());
    EXPECT_EQ(findCheckpoint(folder_, refused)->state.step, 2u);
}

TEST(Checkpoint, RunsThatDoNotFitAreRefusedAndLeftAlone) {
    Bench bench;
    bench.advance(3);
    Checkpoint checkpoint = readCheckpoint(bench.sections());
    checkpoint.values[0].push_back(1);
    Bench other;
    other.advance(1);
    const auto before = other.scene.parameters[0].values;
    EXPECT_THROW(resume(checkpoint, other.run, other.model), Error);
    EXPECT_EQ(other.scene.parameters[0].values, before);
    Bench sgd(makeConfig(OptimizerKind::Sgd)); // keeps one moment where Adam keeps two
    EXPECT_THROW(resume(readCheckpoint(bench.sections()), sgd.run, sgd.model), Error);
}

// A device that is lost, whenever, leaves the state after a whole step.
TEST(Checkpoint, WhateverAStepThrowsTheStateIsWhole) {
    struct Failing final : ImageModel {
        ImageModel& inner;
        int left;
        Failing(ImageModel& m, int calls) : inner(m), left(calls) {}
        void count() const {
            if (const_cast<Failing*>(this)->left-- == 0)
                throw Error(ErrorKind::Device, "lost");
        }
        std::size_t views() const override { return inner.views(); }
        std::pair<int, int> size(std::size_t v) const override { return inner.size(v); }
        Image picture(std::size_t v, std::uint32_t s, const PassKey& k, bool difference) override { return count(), inner.picture(v, s, k, difference); }
        ImageHalves renderHalves(std::size_t v, std::uint32_t s, const PassKey& k, bool d, const SampleRanges& c) override {
            return count(), inner.renderHalves(v, s, k, d, c);
        }
        void setSecondValues(std::uint32_t p, std::span<const float> v) override { count(), inner.setSecondValues(p, v); }
        std::uint64_t reverse(std::size_t v, std::uint32_t s, const PassKey& k, const Image& a, std::vector<std::vector<double>>& g) override {
            return count(), inner.reverse(v, s, k, a, g);
        }
        std::uint64_t reverseApart(std::size_t v, std::uint32_t s, const PassKey& k, const Image& a, std::vector<std::vector<double>>& g, FirstVertices* f) override {
            return count(), inner.reverseApart(v, s, k, a, g, f);
        }
        std::uint64_t reverseHalves(std::size_t v, std::uint32_t s, const PassKey& k, const Image& a, std::vector<std::vector<double>>& g,
                                    std::vector<std::vector<double>>& h) override {
            return count(), inner.reverseHalves(v, s, k, a, g, h);
        }
        void setParameter(std::uint32_t p, std::span<const float> v) override { count(), inner.setParameter(p, v); }
        void endStep() override { count(); }
        void publish() override { count(); }
    };
    constexpr int kCallsPerStep = 2 * 2 + 1 + 2 + 1 + 2; // the first has no values of an earlier one
    constexpr int kCurvatureCalls = 2 + 2 * 2;           // beside, in the first step
    for (const OptimizerKind kind : {OptimizerKind::Adam, OptimizerKind::Auto}) {
        Bench whole(makeConfig(kind));
        whole.advance(20);
        const int first = kCallsPerStep - 2 + (kind == OptimizerKind::Auto ? kCurvatureCalls : 0);
        for (int calls = first; calls < first + 10 * kCallsPerStep; ++calls) { // curvature is measured again in the ninth step
            Bench bench(makeConfig(kind));
            Failing failing(bench.model, calls);
            Optimization run(failing, bench.scene, makeConfig(kind), {0, 1});
            EXPECT_THROW(test::runSteps(run), Error);
            ASSERT_EQ(run.state().history.size(), run.state().step);
            const auto sections = checkpointSections(run, bench.model, {}, "", "");
            Bench second(makeConfig(kind));
            resume(readCheckpoint(sections), second.run, second.model);
            second.advance(20 - second.run.state().step);
            for (const std::size_t p : {0, 1})
                EXPECT_EQ(second.scene.parameters[p].values, whole.scene.parameters[p].values) << calls;
        }
    }
}

} // namespace
} // namespace cmpg

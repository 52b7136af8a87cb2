// The files a run leaves, and the line it shows.
#include "app/progress.h"
#include "app/run_folder.h"
#include "base/error.h"
#include "session/output.h"
#include "support/temp_folder.h"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

namespace cmpg {
namespace {

namespace fs = std::filesystem;

class RunFolderFiles : public testing::Test {
  protected:
    std::vector<std::string> csv() const {
        std::ifstream in(folder_ / "loss.csv");
        std::vector<std::string> lines;
        for (std::string line; std::getline(in, line);)
            lines.push_back(line);
        return lines;
    }

    const test::TempFolder temporary_;
    const fs::path folder_ = temporary_ / "run"; // is not there yet
};

// Whatever keeps it from being made is an error of the output.
TEST_F(RunFolderFiles, AFolderThatCannotBeMadeIsNamed) {
    fs::create_directories(folder_);
    fs::create_symlink("circle", folder_ / "circle");
    std::ofstream(folder_ / "file");
    for (const fs::path& folder : {folder_ / "circle", folder_ / "circle" / "deeper", folder_ / "file", folder_ / std::string(300, 'a')})
        try {
            makeFolder(folder);
            ADD_FAILURE() << folder;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind, ErrorKind::Output) << folder;
            EXPECT_FALSE(error.cause.empty()) << folder;
        }
}

TEST_F(RunFolderFiles, CsvHasAHeaderAndAFlushedRowPerStep) {
    RunFolder files(folder_);
    v1::RecoveryStep step{.loss = 0.125, .regularizer = 0.5, .rate = 0.02, .imageSeconds = 1, .gradientSeconds = 2, .updateSeconds = 0.25, .gradientNorm = 5,
                          .dropped = 6};
    for (step.step = 0; step.step < 3; ++step.step) {
        files.appendStep(step);
        EXPECT_EQ(csv().size(), step.step + 2); // read back while the file is still open
    }
    EXPECT_EQ(csv()[0], "step,loss,loss_error,regularizer,lr,seconds_primal,seconds_gradient,seconds_update,gradient_norm,dropped");
    EXPECT_EQ(csv()[3], "2,0.125,0,0.5,0.02,1.0000,2.0000,0.2500,5,6");
}

TEST_F(RunFolderFiles, ImagesOfViewsAreNumberedAndHaveTheirValues) {
    RunFolder files(folder_);
    const std::vector<Image> images{Image(6, 4, 3, 0.25f), Image(5, 3, 3, -2.f)};
    for (std::size_t view = 0; view < images.size(); ++view)
        files.writeView("difference", view, images.size(), images[view]);
    files.writeView("final", 0, 1, images[0]); // a single one has no number
    files.writeGradient("wall.baseColor", images[1]);
    const std::pair<const char*, int> expected[] = {
        {"difference.0.exr", 0}, {"difference.1.exr", 1}, {"final.exr", 0}, {"gradients/wall.baseColor.exr", 1}};
    for (const auto& [name, image] : expected) {
        const Image found = readImage(folder_ / name).image;
        EXPECT_EQ(found.width, images[std::size_t(image)].width) << name;
        EXPECT_EQ(found.values, images[std::size_t(image)].values) << name;
    }
    EXPECT_EQ(files.outputs().size(), 5u); // loss.csv too
    for (const auto& [name, path] : files.outputs())
        EXPECT_TRUE(fs::exists(path)) << name;
}

TEST_F(RunFolderFiles, WhatCannotBeWrittenIsToldAndTheRestIsWritten) {
    RunFolder files(folder_);
    std::vector<std::string> failures;
    files.tolerate([&](const Error& error) { failures.push_back(error.what()); });
    std::ofstream(folder_ / "gradients") << "in the way";
    const Image image(2, 2, 3, 1.f);
    files.writeGradient("wall.baseColor", image);
    files.writeView("final", 0, 1, image);
    EXPECT_EQ(failures.size(), 1u);
    EXPECT_TRUE(fs::exists(folder_ / "final.exr"));
}

TEST_F(RunFolderFiles, WhatIsReadIsNotWrittenOver) {
    const fs::path scenes = folder_ / "scenes", run = scenes / "run";
    fs::create_directories(run);
    for (const fs::path& file : {scenes / "room.gltf", scenes / "target.exr", run / "target.exr", run / "photo.exr", run / "final.2.exr"})
        std::ofstream(file) << "x";
    const auto refused = [&](const fs::path& output, const fs::path& scene, const std::vector<fs::path>& pictures) {
        try {
            requireApart(output, scene, pictures);
            return false;
        } catch (const Error& error) {
            EXPECT_EQ(error.kind, ErrorKind::Usage) << error.what();
            return true;
        }
    };
    const fs::path scene = scenes / "room.gltf";
    EXPECT_TRUE(refused(scenes, scene, {}));
    EXPECT_TRUE(refused(run / "..", scene, {})) << "by another name";
    EXPECT_FALSE(refused(run, scene, {scenes / "target.exr"}));
    EXPECT_FALSE(refused(run, scene, {run / "photo.exr"}));
    EXPECT_TRUE(refused(run, scene, {run / "photo.exr", run / "target.exr"}));
    EXPECT_TRUE(refused(run, scene, {run / "final.2.exr"}));
    EXPECT_FALSE(refused(scenes / "new", scene, {scenes / "target.exr"}));
}

TEST_F(RunFolderFiles, RefusesAPlaceItCannotWriteTo) {
    fs::create_directories(folder_);
    std::ofstream(folder_ / "file") << "x";
    try {
        RunFolder files(folder_ / "file");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.kind, ErrorKind::Output);
    }
}

TEST(Progress, LineTellsStepLossRateAndTimeLeft) {
    v1::RecoveryStep report;
    report.step = 11;
    report.loss = 1.234e-3;
    EXPECT_EQ(progressLine(report, 200, 3.4e6, 83), "step 12/200  loss 1.2340e-03  3.40 M samples/s  ETA 1:23");
    EXPECT_NE(progressLine(report, 200, 1, 7509).find("ETA 2:05:09"), std::string::npos);
    EXPECT_NE(progressLine(report, 200, 1, 7).find("ETA 7 s"), std::string::npos);
    report.dropped = 5;
    EXPECT_NE(progressLine(report, 200, 1, 7).find("dropped 5"), std::string::npos);
}

TEST(Progress, RewritesOneLineOnATerminalAndPrintsAFewElsewhere) {
    for (const bool terminal : {true, false}) {
        std::ostringstream out;
        Progress progress(out, terminal, 100);
        v1::RecoveryStep report;
        for (report.step = 0; report.step < 100; ++report.step)
            progress.update(report);
        progress.finish();
        const std::string text = out.str();
        const auto lines = std::count(text.begin(), text.end(), '\n'), returns = std::count(text.begin(), text.end(), '\r');
        EXPECT_EQ(lines, terminal ? 1 : 21);
        EXPECT_EQ(returns, terminal ? 100 : 0);
        EXPECT_NE(text.rfind("step 100/100"), std::string::npos);
    }
}

TEST(Progress, TheLastLineIsThereWhereverARunEnds) {
    for (const std::uint32_t steps : {40u, 42u}) { // one that has a line of its own, and one that has not
        std::ostringstream out;
        Progress progress(out, false, 100);
        v1::RecoveryStep report;
        for (report.step = 0; report.step < steps; ++report.step)
            progress.update(report);
        progress.finish();
        const std::string text = out.str(), last = "step " + std::to_string(steps) + "/100";
        EXPECT_EQ(text.find(last), text.rfind(last));
        EXPECT_NE(text.find(last), std::string::npos) << text;
    }
}

} // namespace
} // namespace cmpg

// The files a run leaves, and the line it shows.
#include "base/error.h"
#include "linear_model.h"
#include "optimize/progress.h"
#include "optimize/run_folder.h"

#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

namespace cmpg {
namespace {

namespace fs = std::filesystem;
using test::LinearModel;

class RunFolderFiles : public testing::Test {
  protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / ("cmpg_run_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
        fs::remove_all(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::vector<std::string> csv() const {
        std::ifstream in(folder_ / "loss.csv");
        std::vector<std::string> lines;
        for (std::string line; std::getline(in, line);)
            lines.push_back(line);
        return lines;
    }

    fs::path folder_;
};

TEST_F(RunFolderFiles, CsvHasAHeaderAndAFlushedRowPerStep) {
    RunFolder files(folder_);
    StepReport report;
    report.loss = 0.125;
    report.regularizer = 0.5;
    report.rate = 0.02;
    report.secondsPrimal = 1;
    report.secondsGradient = 2;
    report.secondsUpdate = 0.25;
    report.gradientNorm = {3, 4};
    report.dropped = 6;
    for (report.step = 0; report.step < 3; ++report.step) {
        files.appendStep(report);
        EXPECT_EQ(csv().size(), report.step + 2); // read back while the file is still open
    }
    EXPECT_EQ(csv()[0], "step,loss,loss_error,regularizer,lr,seconds_primal,seconds_gradient,seconds_update,gradient_norm,dropped");
    EXPECT_EQ(csv()[3], "2,0.125,0,0.5,0.02,1.0000,2.0000,0.2500,5,6");
}

TEST_F(RunFolderFiles, ImagesAndGradientsAreWhatTheRunHas) {
    Scene scene = test::makeScene();
    OptimizeConfig config;
    config.steps = 5;
    config.targets = test::makeTargets(2, 6, 4);
    LinearModel model(scene, 2, 6, 4, 0);
    Optimization run(model, scene, config, {0, 1});
    RunFolder files(folder_);
    files.writeTargets(run);
    files.writeInitial(run, 4);
    run.run([&](const StepReport& report) { files.appendStep(report); });
    files.writeImages(run, 4);

    for (std::size_t view = 0; view < 2; ++view) {
        const std::string end = view == 0 ? ".0.exr" : ".1.exr";
        EXPECT_EQ(readImage(folder_ / ("target" + end)).image.values, config.targets[view].image.values);
        const Image before = readImage(folder_ / ("initial" + end)).image, after = readImage(folder_ / ("final" + end)).image;
        const Image difference = readImage(folder_ / ("difference" + end)).image;
        EXPECT_EQ(after.values, run.render(view, 4).values);
        EXPECT_NE(before.values, after.values);
        for (std::size_t i = 0; i < before.values.size(); ++i)
            ASSERT_EQ(difference.values[i], after.values[i] - before.values[i]);
    }
    const Image gradient = readImage(folder_ / "gradients" / "wall.baseColor.exr").image;
    ASSERT_EQ(gradient.values.size(), 48u);
    for (std::size_t i = 0; i < 48; ++i)
        EXPECT_EQ(gradient.values[i], float(run.gradients()[0][i]));
    EXPECT_TRUE(fs::exists(folder_ / "gradients" / "lamp.emission.exr"));
    for (const auto& [name, path] : files.outputs())
        EXPECT_TRUE(fs::exists(path)) << name;
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

TEST(RunFolder, FileNamesAreSafe) {
    EXPECT_EQ(parameterFileName("wall.baseColor"), "wall.baseColor");
    EXPECT_EQ(parameterFileName("../a/b\n.normal").find_first_of("/\\\n"), std::string::npos);
    EXPECT_NE(parameterFileName("a/b.normal"), parameterFileName("a:b.normal")); // no two parameters share a file
}

TEST(Progress, LineTellsStepLossRateAndTimeLeft) {
    StepReport report;
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
        StepReport report;
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

} // namespace
} // namespace cmpg

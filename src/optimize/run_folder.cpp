// The folder an optimisation writes.
#include "optimize/run_folder.h"

#include "base/error.h"
#include "scene/gltf_export.h"

#include <cmath>
#include <cstdio>

namespace cmpg {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHeader = "step,loss,regularizer,lr,seconds_primal,seconds_gradient,seconds_update,gradient_norm,dropped\n";

void makeFolder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (!fs::is_directory(folder))
        throw Error(ExitCode::Output, "cannot make the folder " + folder.string(),
                    error ? error.message() : "a file of that name is in the way", "choose another folder with -o");
}

// initial.exr, or initial.<view>.exr where there are several.
std::string viewFile(const std::string& what, std::size_t view, std::size_t views) {
    return views == 1 ? what + ".exr" : what + "." + std::to_string(view) + ".exr";
}

} // namespace

std::string parameterFileName(const std::string& parameterName) { return fileName(parameterName); }

Image parameterImage(const Parameter& parameter, std::span<const double> values) {
    Image image(int(parameter.width), int(parameter.height), int(parameter.channels));
    for (std::size_t i = 0; i < image.values.size(); ++i)
        image.values[i] = float(values[i]);
    return image;
}

RunFolder::RunFolder(fs::path folder) : path_(std::move(folder)) {
    makeFolder(path_);
    const fs::path file = path_ / "loss.csv";
    csv_.open(file, std::ios::trunc);
    csv_ << kHeader << std::flush;
    if (!csv_)
        throw Error(ExitCode::Output, "cannot write " + file.string(), "the folder is read-only or the disk full",
                    "choose another folder with -o");
    outputs_.emplace_back("loss", file);
}

void RunFolder::writeImage(const std::string& name, const fs::path& file, const Image& image) {
    makeFolder(file.parent_path());
    writeExr(file, image);
    outputs_.emplace_back(name, file);
}

void RunFolder::writeTargets(const Optimization& run) {
    const std::vector<Target>& targets = run.config().targets;
    for (std::size_t view = 0; view < targets.size(); ++view) {
        const std::string name = viewFile("target", view, targets.size());
        writeImage(name, path_ / name, targets[view].image);
    }
}

void RunFolder::writeInitial(Optimization& run, std::uint32_t spp) {
    const std::size_t views = run.config().targets.size();
    initial_.clear();
    for (std::size_t view = 0; view < views; ++view) {
        const std::string name = viewFile("initial", view, views);
        initial_.push_back(run.render(view, spp));
        writeImage(name, path_ / name, initial_.back());
    }
}

void RunFolder::appendStep(const StepReport& report) {
    double squares = 0;
    for (const double norm : report.gradientNorm)
        squares += norm * norm;
    char row[320];
    std::snprintf(row, sizeof row, "%u,%.9g,%.9g,%.6g,%.4f,%.4f,%.4f,%.6g,%llu\n", report.step, report.loss, report.regularizer,
                  report.rate, report.secondsPrimal, report.secondsGradient, report.secondsUpdate, std::sqrt(squares),
                  static_cast<unsigned long long>(report.dropped));
    csv_ << row << std::flush;
    if (!csv_)
        throw Error(ExitCode::Output, "cannot write " + (path_ / "loss.csv").string(), "the disk is full or the folder was removed");
}

void RunFolder::writeImages(Optimization& run, std::uint32_t spp) {
    const std::size_t views = run.config().targets.size();
    final_.clear();
    for (std::size_t view = 0; view < views; ++view) {
        const std::string name = viewFile("final", view, views);
        final_.push_back(run.render(view, spp));
        writeImage(name, path_ / name, final_.back());
        if (view < initial_.size()) {
            Image difference = final_.back();
            for (std::size_t i = 0; i < difference.values.size(); ++i)
                difference.values[i] -= initial_[view].values[i];
            const std::string differenceName = viewFile("difference", view, views);
            writeImage(differenceName, path_ / differenceName, difference);
        }
    }
    for (std::size_t i = 0; i < run.gradients().size(); ++i) {
        const Parameter& parameter = run.scene().parameters[run.parameters()[i]];
        const std::string name = "gradients/" + parameterFileName(parameter.name) + ".exr";
        writeImage(name, path_ / name, parameterImage(parameter, run.gradients()[i]));
    }
}

void RunFolder::writeScene(const Optimization& run) {
    exportGltf(run.scene(), run.parameters(), path_);
    outputs_.emplace_back("scene.gltf", path_ / "scene.gltf");
    outputs_.emplace_back("parameters", path_ / "parameters");
}

} // namespace cmpg

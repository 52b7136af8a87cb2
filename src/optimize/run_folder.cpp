// The folder an optimisation writes.
#include "optimize/run_folder.h"

#include "scene/export_folder.h"
#include "scene/file_io.h"
#include "scene/scene_file.h"

#include <cstdio>

namespace cmpg {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHeader = "step,loss,loss_error,regularizer,lr,seconds_primal,seconds_gradient,seconds_update,gradient_norm,dropped\n";

void makeFolder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (!fs::is_directory(folder))
        throw Error(ErrorKind::Output, "cannot make the folder " + folder.string(),
                    error ? error.message() : "a file of that name is in the way", "choose another folder with -o");
}

Error unwritable(const fs::path& file) {
    return {ErrorKind::Output, "cannot write " + file.string(), "the folder is read-only or gone, or the disk full", "choose another folder with -o"};
}

std::string row(std::size_t step, const StepRecord& r) {
    char text[320];
    std::snprintf(text, sizeof text, "%zu,%.9g,%.3g,%.9g,%.6g,%.4f,%.4f,%.4f,%.6g,%llu\n", step, r.loss, r.lossError, r.regularizer, r.rate, r.secondsPrimal,
                  r.secondsGradient, r.secondsUpdate, r.gradientNorm, static_cast<unsigned long long>(r.dropped));
    return text;
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

void RunFolder::attempt(const std::function<void()>& write) {
    if (path_.empty())
        return;
    try {
        write();
    } catch (const Error& error) {
        if (!failed_)
            throw;
        failed_(error);
    }
}

RunFolder::RunFolder(fs::path folder, std::span<const StepRecord> history) : path_(std::move(folder)) {
    if (path_.empty())
        return;
    makeFolder(path_);
    writeLosses(history);
    outputs_.emplace_back("loss", path_ / "loss.csv");
}

void RunFolder::writeLosses(std::span<const StepRecord> history) {
    attempt([&] {
        csv_.close();
        makeFolder(path_);
        std::string text = kHeader;
        for (std::size_t i = 0; i < history.size(); ++i)
            text += row(i, history[i]);
        const fs::path file = path_ / "loss.csv";
        writeFile(file, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
        csv_.clear();
        csv_.open(file, std::ios::app);
        if (!csv_)
            throw unwritable(file);
    });
}

void RunFolder::appendStep(const StepReport& report) {
    if (!csv_.is_open())
        return;
    attempt([&] {
        const fs::path file = path_ / "loss.csv";
        std::error_code ignored;
        csv_ << row(report.step, recordOf(report)) << std::flush;
        if (csv_ && fs::exists(file, ignored)) // what is written into a file that was removed is gone
            return;
        csv_.close();
        csv_.setstate(std::ios::failbit);
        throw unwritable(file);
    });
}

void RunFolder::writeImage(const std::string& name, const fs::path& file, const Image& image) {
    attempt([&] {
        makeFolder(file.parent_path());
        writeExr(file, image);
        outputs_.emplace_back(name, file);
    });
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
    attempt([&] {
        exportScene(run.scene(), run.parameters(), path_);
        outputs_.emplace_back(run.scene().format->exported, path_ / run.scene().format->exported);
        outputs_.emplace_back("parameters", path_ / "parameters");
    });
}

} // namespace cmpg

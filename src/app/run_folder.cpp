// The folder an optimisation writes.
#include "app/run_folder.h"

#include "scene/export_folder.h"
#include "scene/file_io.h"
#include "session/output.h"

#include <cstdio>

namespace cmpg {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHeader = "step,loss,loss_error,regularizer,lr,seconds_primal,seconds_gradient,seconds_update,gradient_norm,dropped\n";

Error unwritable(const fs::path& file) {
    return {ErrorKind::Output, "cannot write " + file.string(), "the folder is read-only or gone, or the disk full", "choose another folder with -o"};
}

std::string row(const v1::RecoveryStep& s) {
    char text[320];
    std::snprintf(text, sizeof text, "%u,%.9g,%.3g,%.9g,%.6g,%.4f,%.4f,%.4f,%.6g,%llu\n", s.step, s.loss, s.lossError, s.regularizer, s.rate, s.imageSeconds,
                  s.gradientSeconds, s.updateSeconds, s.gradientNorm, static_cast<unsigned long long>(s.dropped));
    return text;
}

// Whether pictures of a run have this name.
bool isViewFile(const std::string& name) {
    for (const std::string what : {"target", "initial", "final", "difference"})
        if (name.ends_with(".exr") && name.starts_with(what + "."))
            return true;
    return false;
}

// initial.exr, or initial.<view>.exr where there are several.
std::string viewFile(const std::string& what, std::size_t view, std::size_t views) {
    return views == 1 ? what + ".exr" : what + "." + std::to_string(view) + ".exr";
}

} // namespace

void requireApart(const fs::path& folder, const fs::path& scene, std::span<const fs::path> pictures) {
    std::error_code error;
    const fs::path own = fs::weakly_canonical(folder, error);
    const auto require = [&](const fs::path& file, bool overwritten) {
        const fs::path read = fs::weakly_canonical(file, error);
        if (!error && overwritten && read.parent_path() == own)
            throw Error(ErrorKind::Usage, "the results would be written over " + file.string() + ", which the run reads",
                        "-o names the folder that it stands in", "give the results a folder of their own", {"output"});
    };
    require(scene, true);
    for (const fs::path& picture : pictures)
        require(picture, isViewFile(picture.filename().string()));
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

RunFolder::RunFolder(fs::path folder, std::span<const v1::RecoveryStep> history) : path_(std::move(folder)) {
    if (path_.empty())
        return;
    makeFolder(path_);
    writeLosses(history);
    outputs_.emplace_back("loss", path_ / "loss.csv");
}

void RunFolder::writeLosses(std::span<const v1::RecoveryStep> history) {
    attempt([&] {
        csv_.close();
        makeFolder(path_);
        std::string text = kHeader;
        for (const v1::RecoveryStep& step : history)
            text += row(step);
        const fs::path file = path_ / "loss.csv";
        writeFile(file, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
        csv_.clear();
        csv_.open(file, std::ios::app);
        if (!csv_)
            throw unwritable(file);
    });
}

void RunFolder::appendStep(const v1::RecoveryStep& step) {
    if (!csv_.is_open())
        return;
    attempt([&] {
        const fs::path file = path_ / "loss.csv";
        std::error_code ignored;
        csv_ << row(step) << std::flush;
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

void RunFolder::writeView(const std::string& what, std::size_t view, std::size_t views, const Image& image) {
    const std::string name = viewFile(what, view, views);
    writeImage(name, path_ / name, image);
}

void RunFolder::writeGradient(const std::string& parameter, const Image& gradient) {
    const std::string name = "gradients/" + fileName(parameter) + ".exr";
    writeImage(name, path_ / name, gradient);
}

void RunFolder::writeScene(const v1::Scene& scene) {
    attempt([&] {
        const fs::path file = scene.exportTo(path_);
        outputs_.emplace_back(file.filename().string(), file);
        outputs_.emplace_back("parameters", path_ / "parameters");
    });
}

} // namespace cmpg

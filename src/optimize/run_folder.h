// The folder an optimisation writes: what it was, how it went, what came out.
#pragma once

#include "base/error.h"
#include "optimize/optimize.h"

#include <fstream>

namespace cmpg {

//   loss.csv                 one row per step, flushed
//   initial.exr, final.exr, difference.exr   images of the views; difference = final - initial
//   target.exr               as compared: exposed, linear
//   gradients/<name>.exr     dLoss/dparameter of the last step
//   parameters/<name>.exr    exact values          (exportScene)
//   scene.gltf ...           the optimised scene   (exportScene)
// With several views the images are <name>.<view>.exr, views counted from 0. Every file but loss.csv is written aside and renamed,
// so that what is there is whole at any time.
class RunFolder {
  public:
    // An empty one: nothing is written, as on all ranks but the first.
    // Makes the folder and starts loss.csv with the steps of a run that this one goes on from. Error(Output) if that fails.
    explicit RunFolder(std::filesystem::path folder, std::span<const StepRecord> history = {});
    // From now on what cannot be written is told instead of thrown, and everything else is written all the same.
    using Failed = std::function<void(const Error& error)>;
    void tolerate(Failed failed) { failed_ = std::move(failed); }
    // Runs what writes to the folder.
    void attempt(const std::function<void()>& write);

    void writeTargets(const Optimization& run);
    // Initial images: before the first step.
    void writeInitial(Optimization& run, std::uint32_t spp);
    // After a failure rows wait for writeLosses().
    void appendStep(const StepReport& report);
    void writeLosses(std::span<const StepRecord> history); // loss.csv anew
    // The results; equally at the end and after an interruption.
    // The scene comes first: it is what must not get lost.
    void writeScene(const Optimization& run);
    void writeImages(Optimization& run, std::uint32_t spp); // final, difference, gradients

    const std::filesystem::path& path() const { return path_; }
    // For --json and run.json: what was written so far, "initial" -> path, ...
    const std::vector<std::pair<std::string, std::filesystem::path>>& outputs() const { return outputs_; }
    // Of the views, in linear values; for a contact sheet. Empty before they were written.
    const std::vector<Image>& initialImages() const { return initial_; }
    const std::vector<Image>& finalImages() const { return final_; }

  private:
    void writeImage(const std::string& name, const std::filesystem::path& file, const Image& image);

    std::filesystem::path path_;
    std::ofstream csv_; // closed: it could not be written
    Failed failed_;
    std::vector<std::pair<std::string, std::filesystem::path>> outputs_;
    std::vector<Image> initial_, final_;
};

// A texture-shaped EXR image of one value per entry of a parameter.
Image parameterImage(const Parameter& parameter, std::span<const double> values);
// The parameter's name as a file name without extension, the same as the export's parameters/<name>.exr.
std::string parameterFileName(const std::string& parameterName);

} // namespace cmpg

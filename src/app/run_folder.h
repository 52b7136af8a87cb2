// The folder an optimisation writes: what it was, how it went, what came out.
#pragma once

#include "base/error.h"
#include "scene/image.h"

#include <cmpg/recovery.h>

#include <fstream>
#include <span>

namespace cmpg {

// Error(Usage) where a run with this folder would write over what it reads: the scene, whose folder may not be this one, or a picture of a name that it gives.
void requireApart(const std::filesystem::path& folder, const std::filesystem::path& scene, std::span<const std::filesystem::path> pictures);

//   loss.csv                 one row per step, flushed
//   initial.exr, final.exr, difference.exr   images of the views; difference = final - target, where that has weight
//   target.exr               as compared: exposed, linear
//   gradients/<name>.exr     dLoss/dparameter of the last step
//   parameters/<name>.exr    exact values          (exportScene)
//   scene.gltf ...           the optimised scene   (exportScene)
// With several views the images are <name>.<view>.exr, views counted from 0. Every file but loss.csv is written aside and renamed,
// so that what is there is whole at any time.
class RunFolder {
  public:
    // An empty one: nothing is written, as on all ranks but the first.
    // Makes the folder and starts loss.csv with the steps of a run that this one continues. Error(Output) if that fails.
    explicit RunFolder(std::filesystem::path folder, std::span<const v1::RecoveryStep> history = {});
    // From now on what cannot be written is told instead of thrown, and everything else is written all the same.
    using Failed = std::function<void(const Error& error)>;
    void tolerate(Failed failed) { failed_ = std::move(failed); }
    // Runs what writes to the folder.
    void attempt(const std::function<void()>& write);

    // After a failure rows wait for writeLosses().
    void appendStep(const v1::RecoveryStep& step);
    void writeLosses(std::span<const v1::RecoveryStep> history); // loss.csv anew
    // The results; equally at the end and after an interruption.
    // The scene comes first: it is what must not get lost.
    void writeScene(const v1::Scene& scene);
    void writeView(const std::string& what, std::size_t view, std::size_t views, const Image& image); // "target", "initial" ...
    void writeGradient(const std::string& parameter, const Image& gradient);

    const std::filesystem::path& path() const { return path_; }
    // For --json and run.json: what was written so far, "initial" -> path, ...
    const std::vector<std::pair<std::string, std::filesystem::path>>& outputs() const { return outputs_; }

  private:
    void writeImage(const std::string& name, const std::filesystem::path& file, const Image& image);

    std::filesystem::path path_;
    std::ofstream csv_; // closed: it could not be written
    Failed failed_;
    std::vector<std::pair<std::string, std::filesystem::path>> outputs_;
};

} // namespace cmpg

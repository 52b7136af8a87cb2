// A scene on a device as the options want it: what every rendering command starts from.
#pragma once

#include "scene/scene.h"
#include "session/report.h"

#include <cmpg/device.h>
#include <cmpg/report.h>

namespace cmpg {

// The scene of the options as it is in its file.
Scene readScene(const Options& options);
// The same with the values of --set; logs its warnings.
v1::Scene openScene(const Options& options);

// Names of what --param selects; warns of what is left out.
std::vector<std::string> parametersOf(const Options& options, const v1::Scene& scene);

// What a command makes an image of.
struct SeenView {
    std::string camera;
    int width = 0, height = 0; // pixels
};

// As asked, else those of `like` (a target or adjoint), else `defaultWidth` wide by the
// camera's aspect ratio. Error(Input) when `like` has another size than asked for.
SeenView viewOf(const Options& options, const Scene& scene, const std::string& camera, const Image* like = nullptr, int defaultWidth = 512);

// What a command does on a device, as run.json and the report have it.
class RunRecord {
  public:
    RunRecord(const Options& options, Report& report) : options_(options), report_(report) {}

    // The device is open and the renderer made, for images of this view: the configuration is printed, and written to run.json in `folder` unless
    // that is empty.
    void begin(const SeenView& view, std::uint32_t depth, const std::filesystem::path& folder);
    // Rewrites run.json for what was decided on the way.
    void record(const std::function<void(Options&)>& change);
    // Error(Numerical) if a substantial part of the contributions was lost, or `result` holds values that are not finite. Warns of what was left out.
    void requireFinite(const Image* result) const;

  private:
    const Options& options_;
    Report& report_;
    Options effective_; // of run.json
    std::filesystem::path folder_;
};

// Warns where the gradient of a parameter is nothing but zeros, and says why as far as its values in `scene` tell.
void warnUnreached(const Scene& scene, const std::string& parameter, bool anyGradient);

// Warns where the options leave light sampling out of a scene with lights that nothing else finds. openScene() does it.
void warnOfUnsampledLights(const Options& options, const Scene& scene);

class Session {
  public:
    // Reads the scene; no device yet.
    Session(const Options& options, Report& report);

    v1::Scene scene;                                     // --set applied
    std::vector<std::string> parameters;                 // selected by --param
    const Scene& host() const;                           // the scene itself
    const Parameter& parameter(std::size_t index) const; // of `parameters`

    v1::Device& openDevice(); // the first time: after all other input was checked
    const Device& device() const;
    double compileSeconds() const; // of the open device, so far
    // What works on the device is made, for images of this view. The report takes up the times so far. Then as RunRecord::begin().
    void begin(const SeenView& view, const std::filesystem::path& folder);
    void record(const std::function<void(Options&)>& change) { record_.record(change); }

    // Costs and losses of a pass, or of all passes of a recovery, go to the report.
    void add(const v1::PassReport& pass);
    // Tells how directions were drawn; saves the guide of `learned`, a renderer or a recovery, as the options want it.
    template <class Learned> void tell(const v1::PassReport& pass, const Learned& learned) {
        tellSampling(pass);
        if (!savesGuide())
            return;
        learned.saveGuide(options_.saveGuide);
        report_.outputs.emplace_back("guide", options_.saveGuide);
    }
    // Device times and memory go to the report. Then as RunRecord::requireFinite().
    void finish(const Image* result = nullptr);

  protected:
    const Options& options_;
    Report& report_;

  private:
    void tellSampling(const v1::PassReport& pass);
    bool savesGuide() const;

    Stopwatch loading_;
    std::optional<v1::Device> device_;
    RunRecord record_;
};

} // namespace cmpg

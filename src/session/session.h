// A scene on a device as the options want it: what every rendering command starts from.
#pragma once

#include "render/renderer.h"
#include "session/report.h"

namespace cmpg {

// Loads the scene, prints its warnings on stderr and applies --set.
// The scene of the options as it is in its file.
Scene readScene(const Options& options);
// The same with the values of --set; logs its warnings.
Scene openScene(const Options& options);

// The camera and image size of a view: as asked, else those of `like` (a target or adjoint), else `defaultWidth` wide by the
// camera's aspect ratio. Error(Input) when `like` has another size than asked for.
View viewOf(const Options& options, const Scene& scene, const std::string& camera, const Image* like = nullptr, int defaultWidth = 512);

// How a renderer of the scene is built, as far as options say it.
RenderConfig renderConfig(const Options& options, const Scene& scene, const std::vector<std::uint32_t>& differentiable);

// What a command does on a device, as run.json and the report have it.
class RunRecord {
  public:
    RunRecord(const Options& options, Report& report) : options_(options), report_(report) {}

    // The device is open and the renderer made, for images of this view: the configuration is printed, and written to run.json in `folder` unless
    // that is empty.
    void begin(const View& view, std::uint32_t depth, const std::filesystem::path& folder);
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

// Warns where the gradient of a parameter is nothing but zeros.
void warnUnreached(const std::string& parameter, bool anyGradient);

class Session {
  public:
    // Reads the scene; no device yet.
    Session(const Options& options, Report& report);

    Scene scene;
    std::vector<std::uint32_t> parameters; // selected by --param
    // Opens the device and has `make` make a renderer that outlives all other use of the session, for the scene as it is now: after all other
    // input was checked, which needs no device. The report takes up the times so far. Then as RunRecord::begin().
    void prepare(const View& view, const std::filesystem::path& folder, const std::function<Renderer&(const RenderConfig&)>& make);
    void openDevice(); // that prepare() opens if nobody has
    Renderer& renderer() { return *renderer_; } // after prepare()
    Device& device() { return *device_; }       // after either
    void record(const std::function<void(Options&)>& change) { record_.record(change); }
    // Device times, memory and statistics go to the report. Then as RunRecord::requireFinite().
    void finish(const Image* result = nullptr);

  private:
    const Options& options_;
    Report& report_;
    Stopwatch loading_;
    std::optional<Device> device_;
    Renderer* renderer_ = nullptr;
    RunRecord record_;
};

} // namespace cmpg

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

class Session {
  public:
    // Reads the scene; no device yet.
    Session(const Options& options, Report& report);

    Scene scene;
    std::vector<std::uint32_t> parameters; // selected by --param
    // Opens the device and builds the renderer and its kernels for the passes in `modes`, for the scene as it is now: after all other input
    // was checked, which needs no device. The report takes up the view's size and the times so far. The configuration is printed, and
    // written to run.json in `folder` unless that is empty.
    void prepare(const View& view, const std::filesystem::path& folder, std::initializer_list<Renderer::Mode> modes, bool layers = false);
    // The same with a renderer that `make` makes, and that outlives all other use of the session.
    void prepare(const View& view, const std::filesystem::path& folder, const std::function<Renderer&(const RenderConfig&)>& make);
    void openDevice(); // that prepare() opens if nobody has
    Renderer& renderer() { return *renderer_; } // after prepare()
    Device& device() { return *device_; }       // after either
    // Warns where the gradient of a parameter (by index into the scene's) is nothing but zeros.
    void warnUnreached(std::uint32_t parameter, bool anyGradient);
    // Rewrites run.json, in the folder of prepare(), for what was decided on the way.
    void record(const std::function<void(Options&)>& change);
    // Device times, memory and statistics go to the report, warnings to stderr. Error(Numerical) if a substantial part of the
    // contributions was lost, or `result` holds values that are not finite.
    void finish(const Image* result = nullptr);

  private:
    const Options& options_;
    Report& report_;
    Stopwatch loading_;
    std::optional<Device> device_;
    std::unique_ptr<Renderer> own_;
    Renderer* renderer_ = nullptr;
    Options effective_; // of run.json
    std::filesystem::path folder_;
};

} // namespace cmpg

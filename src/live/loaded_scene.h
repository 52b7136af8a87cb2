// The scene of a session with its targets, and the way back to the values it was loaded with.
#pragma once

#include "live/live_session.h"
#include "optimize/target.h"
#include "render/renderer.h"

#include <map>
#include <set>

namespace cmpg {

class LoadedScene {
  public:
    // As the options want it. Targets are opened by openTargets(). `number`: of the scene in the session.
    LoadedScene(const Options& options, std::uint32_t number);

    Scene scene;
    std::shared_ptr<const LiveScene> info;
    LiveSettings initialSettings(const Options& options) const; // camera, size, parameters

    // Those of --target, else target.exr beside the scene if it is there. All or none.
    void openTargets(const Options& options);
    void openTarget(const Options& options, const std::string& text, const std::string& camera);
    void setTarget(const Camera& camera, Image image);
    std::size_t views() const { return targets.size(); }
    View view(std::size_t index) const { return {&cameras[index], targets[index].image.width, targets[index].image.height}; }
    std::vector<Target> targets;
    std::vector<Camera> cameras; // one per target

    // Has the values as floats and remembers the first ones.
    void differentiate(std::span<const std::uint32_t> parameters);
    void restore(); // all values
    void fill(std::span<const std::uint32_t> parameters, float value); // within their ranges
    std::vector<std::uint32_t> remembered() const; // that may have changed
    std::vector<std::uint32_t> changed() const;    // whose values are others than the first

  private:
    std::map<std::uint32_t, std::vector<float>> initial_;
};

} // namespace cmpg

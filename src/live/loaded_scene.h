// The scene of a session with its targets, and the way back to the values it was loaded with.
#pragma once

#include "live/live_session.h"

#include <cmpg/recovery.h>

#include <map>

namespace cmpg {

class LoadedScene {
  public:
    // As the options want it. Targets are opened by openTargets(). `number`: of the scene in the session.
    LoadedScene(const Options& options, std::uint32_t number);

    v1::Scene scene;
    std::shared_ptr<const LiveScene> info;
    LiveSettings initialSettings(const Options& options) const; // camera, size, parameters

    // Those of --target, else target.exr beside the scene if it is there. All or none.
    void openTargets(const Options& options);
    void openTarget(const Options& options, const std::string& text, const std::string& camera);
    void setTarget(const v1::CameraInfo& camera, Image image);
    std::size_t views() const { return targets.size(); }
    std::vector<v1::Target> targets; // each with its camera

    const v1::ParameterInfo& parameter(std::uint32_t index) const { return info->parameters[index]; }
    std::vector<std::string> names(std::span<const std::uint32_t> parameters) const;
    void remember(std::span<const std::uint32_t> parameters); // their values, if they are the first
    void restore();                                           // all values
    void fill(std::span<const std::uint32_t> parameters, float value); // within their ranges
    std::vector<std::uint32_t> remembered() const;             // that may have changed
    std::vector<std::string> changed() const;                  // names of those whose values are others than the first

  private:
    const v1::CameraInfo& camera(const std::string& name) const; // "": the first

    std::map<std::uint32_t, std::vector<float>> initial_;
};

} // namespace cmpg

// What stands behind the handles of the library's surface.
#pragma once

#include "render/guided_passes.h"
#include "scene/scene.h"
#include "vk/device.h"

#include <cmpg/device.h>
#include <cmpg/options.h>
#include <cmpg/scene.h>

#include <functional>
#include <mutex>
#include <span>
#include <sys/types.h>
#include <unistd.h>
#include <utility>

namespace cmpg::v1 {

struct Device::State {
    State(const std::string& select, std::shared_ptr<Communicator> communicator);

    std::shared_ptr<Communicator> communicator;
    Communicator& ranks() const { return *communicator; }

    pid_t process() const { return process_; } // that opened it; see makeState()
    std::recursive_mutex mutex; // of whoever records, submits or frees; what is asked during a pass may free another renderer
    cmpg::Device device;
    DeviceInfo info;

  private:
    const pid_t process_ = ::getpid();
};

// What stands behind a handle that works with a device, as it is or in what it has. A child of fork() leaves it to the process that opened the device: it has
// neither the driver's threads, for which the end of a device waits, nor mutexes that other threads let go of.
template <class State, class... Arguments> std::shared_ptr<State> makeState(Arguments&&... arguments) {
    return {new State(std::forward<Arguments>(arguments)...), [](State* state) {
                if (state->process() == ::getpid())
                    delete state;
            }};
}

struct Scene::State {
    std::mutex mutex;
    cmpg::Scene scene;
    std::vector<std::uint64_t> revisions; // by parameter: how often it was set
};

// A copy of a scene for a renderer to change: `parameters`, which the globs select, are floats. `revisions`: of the values that were copied.
cmpg::Scene copyOf(Scene::State& state, std::span<const std::string> globs, std::vector<std::uint32_t>& parameters,
                   std::vector<std::uint64_t>& revisions);

ParameterInfo describe(const cmpg::Parameter& parameter);
CameraInfo describe(const cmpg::Camera& camera);
// The camera of its name, else the first, moved. Error(Usage) on what is not finite or out of range.
cmpg::Camera movedCamera(const cmpg::Scene& scene, const CameraInfo& to);

// What PathOptions say of a renderer without a guide, on one rank. Error(Usage) on what is out of range.
RenderConfig renderConfig(const PathOptions& options, const cmpg::Scene& scene, const std::vector<std::uint32_t>& differentiable);

GuidedOptions guidedOptions(const PathOptions& options);

// Error(Usage) that names the option where `valid` does not hold.
void require(bool valid, const std::string& option, const std::string& range);
constexpr std::uint32_t kMostSamples = 1u << 24; // counts stay exact in float
constexpr int kMostEdge = 1 << 15;               // pixels

} // namespace cmpg::v1

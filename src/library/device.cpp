// Devices of the library's surface.
#include "library/states.h"

namespace cmpg::v1 {
namespace {

DeviceInfo toPublic(const cmpg::DeviceInfo& info) { return {info.name, info.driver, info.type, info.usable, info.missing}; }

} // namespace

std::vector<DeviceInfo> Device::list() {
    std::vector<DeviceInfo> devices;
    for (const cmpg::DeviceInfo& info : cmpg::Device::list())
        devices.push_back(toPublic(info));
    return devices;
}

Device::Device(const std::string& select) : state_(std::make_shared<State>(select)) {
    state_->info = toPublic(state_->device.info());
    state_->device.keepKernels(); // renderers come and go
}

const DeviceInfo& Device::info() const { return state_->info; }

std::uint64_t Device::memoryInUse() const {
    const std::lock_guard lock(state_->mutex);
    return state_->device.memory().current;
}

std::uint64_t Device::memoryPeak() const {
    const std::lock_guard lock(state_->mutex);
    return state_->device.memory().peak;
}

} // namespace cmpg::v1

// Devices of the library's surface.
#include "base/communicator.h"
#include "library/ranks.h"
#include "library/states.h"

namespace cmpg::v1 {
namespace {

DeviceInfo toPublic(const cmpg::DeviceInfo& info) { return {info.name, info.driver, info.type, info.usable, info.missing}; }

cmpg::Device open(const std::string& select, Communicator& ranks) {
    divideProcessors(ranks);
    return cmpg::Device(cmpg::Device::Options{.select = select.empty() ? deviceOfRank(ranks) : select});
}

} // namespace

std::vector<DeviceInfo> Device::list() {
    std::vector<DeviceInfo> devices;
    for (const cmpg::DeviceInfo& info : cmpg::Device::list())
        devices.push_back(toPublic(info));
    return devices;
}

Device::State::State(const std::string& select, std::shared_ptr<Communicator> shared)
    : communicator(std::move(shared)), device(together(ranks(), [&] { return open(select, ranks()); })), info(toPublic(device.info())) {
    if (const int other = together(ranks(), [&] { return firstOther(ranks(), info.name + '\n' + info.driver); }))
        throw Error(ErrorKind::Device, "rank " + std::to_string(other) + " has another device or driver than rank 0",
                    "machines with different drivers or graphics processors: their results differ in the last bits",
                    "start the ranks on machines of one kind, or name a device that all have", {"device"});
    device.keepKernels(); // renderers come and go
}

Device::Device(const std::string& select) : Device(select, std::shared_ptr<Communicator>(std::shared_ptr<void>(), &ranks())) {} // which outlive it

Device::Device(const std::string& select, std::shared_ptr<Communicator> communicator)
    : state_(makeState<State>(select, communicator ? std::move(communicator) : std::shared_ptr<Communicator>(std::shared_ptr<void>(), &oneRank()))) {}

const DeviceInfo& Device::info() const { return state_->info; }

std::uint64_t Device::memoryInUse() const {
    const std::lock_guard lock(state_->mutex);
    return state_->device.memory().current;
}

std::uint64_t Device::memoryPeak() const {
    const std::lock_guard lock(state_->mutex);
    return state_->device.memory().peak;
}

void Device::timeKernels() {
    const std::lock_guard lock(state_->mutex);
    state_->device.timeKernels(true);
}

double Device::kernelSeconds() const {
    const std::lock_guard lock(state_->mutex);
    double sum = 0;
    for (const auto& [name, time] : state_->device.kernelTimes())
        sum += time.seconds;
    return sum;
}

std::map<std::string, double> Device::compileSeconds() const {
    const std::lock_guard lock(state_->mutex);
    return state_->device.compileTimes();
}

} // namespace cmpg::v1

// A Vulkan device.
#pragma once

#include <cmpg/communicator.h>
#include <cmpg/error.h>
#include <cmpg/namespace.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace cmpg::v1 {

struct DeviceInfo {
    std::string name = {};    // as the driver reports it
    std::string driver = {};  // driver name and version
    std::string type = {};    // "cpu", "integrated", "discrete", "virtual" or "other"
    bool usable = true;
    std::string missing = {}; // the required features it lacks, where it is not usable
};

// A handle: copies are the same device, which lives as long as something uses it. Passes on one device follow one another, whatever threads
// ask for them; passes on two devices run side by side.
class Device {
  public:
    // Every Vulkan device seen, usable or not. Error(Device) where there is no Vulkan at all; the remedy names the package that brings a driver.
    static std::vector<DeviceInfo> list();

    // `select`: an index into list(), or a part of a name in any case; empty: the best. Error(Device) where none is usable or meant, or it
    // computes wrong results.
    explicit Device(const std::string& select = {});

    // Passes on this device are shared among ranks, each of which has made such a device, makes the same renderers and recoveries on it and asks for the
    // same passes in the same order: all get the same results, which are the bits of one rank alone. The first alone writes checkpoints and guides.
    // `select` may be empty on machines with several graphics processors: ranks take one each. On a CPU device they share the processors, unless
    // LP_NUM_THREADS says otherwise. Error(Device) on all where the ranks' devices or drivers differ. A pass throws Error(Usage) on all where they were
    // given different scenes, values, targets or options, or a time budget, or one of them something that is refused; what ends it on one amidst is told to
    // the others by Communicator::passFailed().
    Device(const std::string& select, std::shared_ptr<Communicator> communicator);

    const DeviceInfo& info() const;
    // Bytes of device memory that is allocated now, and the most that ever were.
    std::uint64_t memoryInUse() const;
    std::uint64_t memoryPeak() const;
    // Seconds that its driver took to compile kernels since the device was opened, by kernel, those of helper threads included.
    std::map<std::string, double> compileSeconds() const;
    // Passes begun from now on measure how long their kernels run, by the device's own clock. On a CPU they take about a tenth longer for it.
    void timeKernels();
    double kernelSeconds() const; // measured so far; 0 where the device has no clock

    struct State;
    const std::shared_ptr<State>& state() const { return state_; }

  private:
    std::shared_ptr<State> state_;
};

} // namespace cmpg::v1

// A Vulkan device.
#pragma once

#include <cmpg/error.h>
#include <cmpg/namespace.h>

#include <cstdint>
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

    const DeviceInfo& info() const;
    // Bytes of device memory that is allocated now, and the most that ever were.
    std::uint64_t memoryInUse() const;
    std::uint64_t memoryPeak() const;

    struct State;
    const std::shared_ptr<State>& state() const { return state_; }

  private:
    std::shared_ptr<State> state_;
};

} // namespace cmpg::v1

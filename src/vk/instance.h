// The Vulkan instance, its validation messages, and what can be said of a physical device before using it.
#pragma once

#include "base/error.h"
#include "vk/device.h"
#include "vk/vulkan.h"

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace cmpg {

// Messages of the validation layers, kept until a place is reached that may throw.
struct ValidationLog {
    std::mutex mutex;
    std::vector<std::string> messages;
};

struct Instance {
    Instance() = default;
    ~Instance(); // warns of messages nobody threw
    Instance(const Instance&) = delete;
    void throwValidationMessages(); // Error(Device) where there are any, and forgets them

    vk::raii::Context context;
    bool debugUtils = false;            // names and labels are possible
    std::unique_ptr<ValidationLog> log; // null without validation
    vk::raii::Instance handle{nullptr};
    vk::raii::DebugUtilsMessengerEXT messenger{nullptr};
};

// What the validation layers look at: calls and their synchronization, or in kernels each access to a buffer as well.
enum class Validation { None, Calls, Kernels };
// What CMPG_VALIDATION says: "" or "0", "gpu", or anything else for calls.
Validation validationAsked();

// `extensions`: required beside those that are used where present.
std::unique_ptr<Instance> createInstance(Validation validation, std::span<const char* const> extensions = {});

// Never empty: throws Error(Device) with the remedy when there is no device at all.
std::vector<vk::raii::PhysicalDevice> physicalDevices(const Instance& instance);

// The device that Device::Options::select means; Error(Device) where it means none.
std::size_t selectDevice(const std::vector<DeviceInfo>& devices, const std::string& select);

DeviceInfo describe(const vk::raii::PhysicalDevice& device);
std::optional<std::uint32_t> computeQueueFamily(const vk::raii::PhysicalDevice& device);
// Whether kernels can read all their tables through storage texel buffers: the formats have the feature, and enough can be bound.
bool readsStorageTexels(const vk::raii::PhysicalDevice& device);
bool isLavapipe(const vk::raii::PhysicalDevice& device);

// Whether an environment variable is set to something other than "" and "0".
bool environmentFlag(const char* name);

// Runs `work`; a Vulkan call that fails becomes an Error that says what was being done.
template <class Work> auto translating(const std::string& doing, Work&& work) -> decltype(work()) {
    try {
        return work();
    } catch (const vk::DeviceLostError&) {
        throw Error(ErrorKind::Device, doing + ": the device was lost", "a kernel ran too long or met a driver fault",
                    "try a smaller memory budget, or another device", {"memory", "device"});
    } catch (const vk::SystemError& error) {
        throw Error(ErrorKind::Device, doing + ": " + error.what());
    }
}

} // namespace cmpg

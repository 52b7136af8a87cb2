// What stands behind the classes of device.h.
#pragma once

#include "base/stopwatch.h"
#include "vk/device.h"
#include "vk/fault.h"
#include "vk/instance.h"
#include "vk/kernel_cache.h"
#include "vk/raw_buffer.h"
#include "vk/spirv_reflection.h"
#include "vk/transfers.h"
#include "vk/vulkan.h"

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <span>

namespace cmpg {

// Who compiles, so that kernels for later do not take the processors of what somebody waits for. For any thread.
class Processors {
  public:
    class Place {
      public:
        // `waits`: until a processor is free; otherwise it is taken whether or not.
        Place(Processors& processors, bool waits);
        ~Place();
        Place(const Place&) = delete;

      private:
        Processors& processors_;
    };

  private:
    std::mutex mutex_;
    std::condition_variable freed_;
    unsigned taken_ = 0;
};

// The kernels of a device, so that those alike are made once. For any thread.
class KernelStore {
  public:
    using Key = std::pair<std::string, std::vector<std::uint32_t>>; // name and constants
    std::shared_ptr<Kernel::Impl> find(const Key& key);             // null: nobody has it
    // One of that name whose code is the same, though other constants were given.
    std::shared_ptr<Kernel::Impl> findSame(const Key& key, const Kernel::Impl& kernel);
    void add(const Key& key, const std::shared_ptr<Kernel::Impl>& kernel);
    void keep(); // those added from now on, until the device goes

  private:
    std::mutex mutex_;
    std::map<Key, std::weak_ptr<Kernel::Impl>> known_;
    bool keeps_ = false;
    std::vector<std::shared_ptr<Kernel::Impl>> kept_;
};

struct Device::Impl {
    Options options;
    std::unique_ptr<Instance> instance; // before all else, so that it outlives that and hears of what was left alive
    vk::raii::PhysicalDevice physical{nullptr};
    DeviceInfo info;
    vk::PhysicalDeviceLimits limits;
    std::uint64_t maxAllocation = 0; // bytes
    std::uint32_t queueFamily = 0;
    std::uint64_t timestampMask = 0; // 0: the queue has no timestamps
    std::uint32_t driverThreads = 1;
    std::uint32_t compileHelpers = 0; // devices beside it that warmUp() may have compile
    KernelVariant variant = KernelVariant::Full;
    bool hostMemory = false; // buffers are mapped: device and host share memory

    vk::raii::Device device{nullptr};
    vk::raii::Queue queue{nullptr};
    vk::raii::Fence fence{nullptr};
    RawBuffer dummy; // what null buffers bind
    std::map<Texel, vk::raii::BufferView> dummyViews; // in the format that a kernel declares: lavapipe compiles anew for another
    std::optional<Transfers> transfers; // from the constructor on

    Fault fault;
    MemoryUse memory;
    bool timesKernels = false;
    std::map<std::string, KernelTime> kernelTimes;
    std::atomic<double> compileSeconds = 0;
    std::map<std::string, double> compileTimes;
    KernelStore kernels;
    const KernelCache kernelCache;
    Processors processors;

    explicit Impl(const Options& options);

    enum class Place { Device, Staging };
    RawBuffer allocate(const std::string& name, std::uint64_t bytes, vk::BufferUsageFlags usage, Place place);
    void submitAndWait(vk::CommandBuffer commands); // behind the transfers that wait
    void submitAndWait(std::span<const vk::CommandBuffer> commands);

    template <class Handle> void setName(const Handle& handle, const std::string& name) const {
        if (!instance->debugUtils)
            return;
        using Raw = typename Handle::CType;
        const auto value = reinterpret_cast<std::uint64_t>(static_cast<Raw>(*handle));
        device.setDebugUtilsObjectNameEXT({Handle::objectType, value, name.c_str()});
    }
};

struct Buffer::Impl {
    Device::Impl* device = nullptr;
    std::string name;
    std::uint64_t bytes = 0; // rounded up to 16
    MemoryKind kind = MemoryKind::Transient;
    Texel texel = Texel::None;
    RawBuffer raw;
    std::map<std::pair<std::uint64_t, std::uint64_t>, vk::raii::BufferView> views; // by offset and bytes

    ~Impl();
    vk::BufferView view(std::uint64_t offset, std::uint64_t range);
};

vk::Format texelFormat(Texel texel);
vk::BufferUsageFlags texelUsage(KernelVariant variant);
vk::DescriptorType descriptorType(KernelInterface::Resource resource);
std::uint64_t texelBytes(Texel texel);
// Bytes to create a texel buffer with. lavapipe compiles a kernel anew when a texel buffer's size is a power of two, or when bits
// 8 to 15 of the view's size are all zero and were not before; sizes padded by this are always alike.
std::uint64_t paddedTexelBytes(std::uint64_t bytes);

struct Kernel::Impl {
    Device::Impl* device = nullptr;
    std::string name;
    KernelInterface interface;
    std::vector<std::uint32_t> spirv; // specialised
    vk::raii::DescriptorSetLayout setLayout{nullptr};
    vk::raii::PipelineLayout pipelineLayout{nullptr};
    vk::raii::Pipeline pipeline{nullptr};
    double createSeconds = 0; // of the pipeline
    bool dispatched = false;  // by warmUp()
};

} // namespace cmpg

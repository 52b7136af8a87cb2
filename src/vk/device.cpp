// Device choice and creation, memory allocation and submission.
#include "vk/device.h"

#include "vk/impl.h"
#include "vk/driver_threads.h"
#include "vk/self_test.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace cmpg {

namespace {

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return text;
}

std::string listText(const std::vector<DeviceInfo>& devices) {
    std::string text = "devices:";
    for (std::size_t i = 0; i < devices.size(); ++i)
        text += (i ? ", " : " ") + std::to_string(i) + " " + devices[i].name +
                (devices[i].usable ? "" : " (lacks " + devices[i].missing + ")");
    return text;
}

std::size_t bestDevice(const std::vector<DeviceInfo>& devices) {
    constexpr std::array<std::string_view, 5> order{"discrete", "integrated", "virtual", "cpu", "other"};
    for (const std::string_view type : order)
        for (std::size_t i = 0; i < devices.size(); ++i)
            if (devices[i].usable && devices[i].type == type)
                return i;
    throw Error(ErrorKind::Device, "no Vulkan device has the required features", listText(devices),
                "update the driver, or install the package mesa-vulkan-drivers, whose driver runs on any CPU");
}

// lavapipe gives each of its threads one contiguous range of workgroups. It has one for each processor that the process may use.
std::uint32_t lavapipeThreads() {
    constexpr std::uint32_t kMost = 32; // LP_MAX_THREADS of Mesa
    std::uint32_t threads = std::min(processorsAllowed(), kMost);
    if (const char* limit = std::getenv("LP_NUM_THREADS"))
        threads = std::clamp(std::uint32_t(std::strtoul(limit, nullptr, 10)), 1u, threads);
    return threads;
}

// Where code is compiled at the first dispatch, and devices share it on disk. LLVM takes 100 MB a thread: a few will do.
std::uint32_t compileHelpersFor(std::uint32_t threads) {
    constexpr std::uint32_t kMost = 3;
    const auto disabled = [](const char* name) { // as Mesa reads it
        const char* value = std::getenv(name);
        const std::string text = value ? lower(value) : "no";
        return text != "0" && text != "n" && text != "no" && text != "f" && text != "false";
    };
    if (disabled("MESA_SHADER_CACHE_DISABLE") || disabled("MESA_GLSL_CACHE_DISABLE"))
        return 0;
    if (const char* asked = std::getenv("CMPG_COMPILERS")) // a hook of tests and measurements
        threads = std::max(1u, std::uint32_t(std::strtoul(asked, nullptr, 10)));
    return std::min(threads - 1, kMost);
}

// Whether there is memory that is fast for the device and for the host. Where the host's reads are not cached they take a hundred times as long as a copy does.
bool sharesMemory(const vk::raii::PhysicalDevice& physical) {
    using Flag = vk::MemoryPropertyFlagBits;
    constexpr vk::MemoryPropertyFlags kAll = Flag::eDeviceLocal | Flag::eHostVisible | Flag::eHostCoherent | Flag::eHostCached;
    const vk::PhysicalDeviceMemoryProperties types = physical.getMemoryProperties();
    return std::any_of(types.memoryTypes.begin(), types.memoryTypes.begin() + types.memoryTypeCount,
                       [&](const vk::MemoryType& type) { return (type.propertyFlags & kAll) == kAll; });
}

// `robust`: accesses out of range do no harm, where the device can see to it.
vk::raii::Device createDevice(const vk::raii::PhysicalDevice& physical, std::uint32_t queueFamily, const DeviceInfo& info, bool robust) {
    const float priority = 1;
    const vk::DeviceQueueCreateInfo queue({}, queueFamily, 1, &priority);
    const vk::PhysicalDeviceFeatures available = physical.getFeatures();
    vk::StructureChain<vk::DeviceCreateInfo, vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features,
                       vk::PhysicalDeviceVulkan13Features>
        chain;
    chain.get<vk::DeviceCreateInfo>().setQueueCreateInfos(queue);
    auto& features10 = chain.get<vk::PhysicalDeviceFeatures2>().features;
    auto& features12 = chain.get<vk::PhysicalDeviceVulkan12Features>();
    features12.scalarBlockLayout = true;
    chain.get<vk::PhysicalDeviceVulkan13Features>().maintenance4 = true;
    // Optional ones.
    features10.robustBufferAccess = available.robustBufferAccess && robust;
    features10.shaderInt64 = available.shaderInt64;
    features10.shaderFloat64 = info.float64;
    features12.shaderBufferInt64Atomics = info.int64Atomics;
    return physical.createDevice(chain.get<vk::DeviceCreateInfo>());
}

} // namespace

std::size_t selectDevice(const std::vector<DeviceInfo>& devices, const std::string& select) {
    if (select.empty())
        return bestDevice(devices);
    std::size_t chosen = devices.size();
    const char* const end = select.data() + select.size();
    if (const auto [rest, error] = std::from_chars(select.data(), end, chosen); error != std::errc() || rest != end)
        chosen = std::size_t(std::find_if(devices.begin(), devices.end(), [&](const DeviceInfo& d) {
                     return lower(d.name).find(lower(select)) != std::string::npos;
                 }) - devices.begin());
    if (chosen >= devices.size())
        throw Error(ErrorKind::Device, "no Vulkan device matches '" + select + "'", listText(devices),
                    "give an index or a part of the name of one of these", {"device"});
    if (!devices[chosen].usable)
        throw Error(ErrorKind::Device, "'" + devices[chosen].name + "' cannot be used: it lacks " + devices[chosen].missing,
                    "an old driver or device", "choose another", {"device"});
    return chosen;
}

Device::Impl::Impl(const Options& o) : options(o), fault(faultFromEnvironment()) {
    const Validation asked = validationAsked();
    const DriverThreads startedByDriver;
    instance = createInstance(asked == Validation::None && options.validation ? Validation::Calls : asked);
    auto devices = physicalDevices(*instance);
    std::vector<DeviceInfo> infos;
    infos.reserve(devices.size());
    for (const auto& candidate : devices)
        infos.push_back(describe(candidate));
    const std::size_t chosen = selectDevice(infos, options.select);
    physical = std::move(devices[chosen]);
    info = infos[chosen];

    const auto properties = physical.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceMaintenance3Properties,
                                                    vk::PhysicalDeviceMaintenance4Properties>();
    limits = properties.get<vk::PhysicalDeviceProperties2>().properties.limits;
    maxAllocation = std::min(properties.get<vk::PhysicalDeviceMaintenance3Properties>().maxMemoryAllocationSize,
                             properties.get<vk::PhysicalDeviceMaintenance4Properties>().maxBufferSize);
    queueFamily = *computeQueueFamily(physical);
    const std::uint32_t timestampBits = physical.getQueueFamilyProperties()[queueFamily].timestampValidBits;
    timestampMask = timestampBits == 0 ? 0 : ~std::uint64_t(0) >> (64 - timestampBits);
    variant = options.portable || environmentFlag("CMPG_PORTABLE") ? KernelVariant::Portable : info.variant;
    // CMPG_TEXELS=uniform has a CPU read as a GPU does.
    if (const char* texels = std::getenv("CMPG_TEXELS"); variant == KernelVariant::Cpu && texels && std::string_view(texels) == "uniform")
        variant = KernelVariant::Full;
    if (isLavapipe(physical)) {
        driverThreads = lavapipeThreads();
        compileHelpers = compileHelpersFor(driverThreads);
    }
    // CMPG_STAGING=1 makes transfers go the way they go on a discrete device.
    hostMemory = (info.type == "cpu" || info.type == "integrated") && sharesMemory(physical) && !environmentFlag("CMPG_STAGING");

    translating("creating the Vulkan device '" + info.name + "'", [&] {
        device = createDevice(physical, queueFamily, info, asked != Validation::Kernels); // the layers look where nothing is to be feared
        startedByDriver.spread(driverThreads);
        queue = device.getQueue(queueFamily, 0);
        transfers.emplace(
            device, queueFamily,
            [this] {
                return allocate("staging", kStagingBytes, vk::BufferUsageFlagBits::eTransferSrc | vk::BufferUsageFlagBits::eTransferDst, Place::Staging);
            },
            [this](std::span<const vk::CommandBuffer> commands) { submitAndWait(commands); });
        fence = device.createFence({});
    });
    dummy = allocate("dummy", paddedTexelBytes(16),
                     vk::BufferUsageFlagBits::eStorageBuffer | vk::BufferUsageFlagBits::eUniformBuffer | texelUsage(variant) | vk::BufferUsageFlagBits::eTransferDst,
                     Place::Device);
    for (const Texel texel : {Texel::Rgba32f, Texel::Rgba32ui, Texel::R32f, Texel::R32ui})
        dummyViews.emplace(texel, device.createBufferView({{}, *dummy.buffer, texelFormat(texel), 0, VK_WHOLE_SIZE}));
    transfers->clear(*dummy.buffer);
    instance->throwValidationMessages(); // nothing was submitted yet, which would
}

RawBuffer Device::Impl::allocate(const std::string& name, std::uint64_t bytes, vk::BufferUsageFlags usage, Place place) {
    const auto outOfMemory = [&](const std::string& cause) {
        return Error(ErrorKind::Device, "cannot allocate " + std::to_string(bytes) + " bytes of device memory for '" + name + "'", cause,
                     "lower the memory budget, the image size or the scene's textures", {"memory"});
    };
    if (bytes > fault.bytes || memory.current > fault.bytes - bytes)
        throw outOfMemory("CMPG_FAULT allows " + std::to_string(fault.bytes) + " bytes");
    if (bytes > maxAllocation)
        throw outOfMemory("'" + info.name + "' allows " + std::to_string(maxAllocation) + " bytes per buffer");
    try {
        RawBuffer raw;
        raw.buffer = device.createBuffer({{}, bytes, usage, vk::SharingMode::eExclusive});
        const vk::MemoryRequirements needs = raw.buffer.getMemoryRequirements();
        using Flag = vk::MemoryPropertyFlagBits;
        const bool mapped = hostMemory || place == Place::Staging;
        const vk::MemoryPropertyFlags required = mapped ? Flag::eHostVisible | Flag::eHostCoherent : vk::MemoryPropertyFlags();
        const vk::MemoryPropertyFlags wanted =
            (place == Place::Staging ? vk::MemoryPropertyFlags() : Flag::eDeviceLocal) |
            (mapped ? Flag::eHostCached : vk::MemoryPropertyFlags());
        // The acceptable type with most of the wanted properties; the first of equals, as the specification orders them.
        const vk::PhysicalDeviceMemoryProperties types = physical.getMemoryProperties();
        int bestScore = -1;
        std::uint32_t best = 0;
        for (std::uint32_t i = 0; i < types.memoryTypeCount; ++i) {
            const vk::MemoryPropertyFlags flags = types.memoryTypes[i].propertyFlags;
            const int score = std::popcount(std::uint32_t(flags & wanted));
            if ((needs.memoryTypeBits >> i & 1) && (flags & required) == required && score > bestScore) {
                bestScore = score;
                best = i;
            }
        }
        if (bestScore < 0)
            throw outOfMemory("the device has no suitable type of memory");
        raw.memory = device.allocateMemory({needs.size, best});
        raw.buffer.bindMemory(*raw.memory, 0);
        raw.allocated = needs.size;
        if (mapped)
            raw.mapped = static_cast<std::byte*>(raw.memory.mapMemory(0, VK_WHOLE_SIZE));
        setName(raw.buffer, name);
        return raw;
    } catch (const vk::SystemError& error) {
        throw outOfMemory(error.what());
    }
}

void Device::Impl::submitAndWait(vk::CommandBuffer commands) {
    if (const vk::CommandBuffer before = transfers->take())
        submitAndWait(std::array{before, commands});
    else
        submitAndWait(std::span(&commands, 1));
}

void Device::Impl::submitAndWait(std::span<const vk::CommandBuffer> commands) {
    translating("running commands on '" + info.name + "'", [&] {
        if (fault.submissions == 0)
            throw vk::DeviceLostError("CMPG_FAULT");
        --fault.submissions;
        queue.submit(vk::SubmitInfo({}, {}, commands), *fence);
        if (device.waitForFences(*fence, true, std::numeric_limits<std::uint64_t>::max()) != vk::Result::eSuccess)
            throw Error(ErrorKind::Device, "the device did not finish");
        device.resetFences(*fence);
    });
    instance->throwValidationMessages();
}

std::vector<DeviceInfo> Device::list() {
    const auto instance = createInstance(Validation::None);
    std::vector<DeviceInfo> infos;
    for (const auto& device : physicalDevices(*instance))
        infos.push_back(describe(device));
    return infos;
}

Device::Device(const Options& options) : impl_(std::make_unique<Impl>(options)) { selfTest(*this); }
Device::~Device() = default;
Device::Device(Device&&) noexcept = default;

const DeviceInfo& Device::info() const { return impl_->info; }
KernelVariant Device::variant() const { return impl_->variant; }
bool Device::portable() const { return impl_->variant == KernelVariant::Portable; }
std::uint32_t Device::driverThreads() const { return impl_->driverThreads; }
const MemoryUse& Device::memory() const { return impl_->memory; }
const std::map<std::string, KernelTime>& Device::kernelTimes() const { return impl_->kernelTimes; }
double Device::compileSeconds() const { return impl_->compileSeconds; }
const std::map<std::string, double>& Device::compileTimes() const { return impl_->compileTimes; }
void Device::keepKernels() { impl_->kernels.keep(); }
void Device::timeKernels(bool on) { impl_->timesKernels = on; }
bool Device::timesKernels() const { return impl_->timesKernels; }
void Device::resetKernelTimes() { impl_->kernelTimes.clear(); }

} // namespace cmpg

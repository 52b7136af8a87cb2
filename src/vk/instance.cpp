// Instance creation with optional validation, and the list of required device features.
#include "vk/instance.h"

#include "base/log.h"
#include "vk/impl.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <utility>

namespace cmpg {

namespace {

constexpr std::uint32_t kApiVersion = VK_API_VERSION_1_3;
// Texel buffers must reach 1 GiB of vec4 for the full variants of the kernels to be used.
constexpr std::uint64_t kMinTexelElements = std::uint64_t(1) << 26;
constexpr const char* kInstallDriver = "install a driver; the package mesa-vulkan-drivers has one that runs on any CPU";
constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

// Where the loader looks for drivers, for the message when it found none.
struct DriverPlaces {
    std::vector<std::string> manifests; // in its usual folders
    std::vector<std::pair<std::string, std::string>> limits; // variables that keep it from looking there, also where they are empty, and their values
    std::string text() const;
};

DriverPlaces driverPlaces() {
    DriverPlaces places;
    std::vector<std::filesystem::path> folders{"/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"};
    if (const char* home = std::getenv("HOME"))
        folders.push_back(std::filesystem::path(home) / ".local/share/vulkan/icd.d");
    for (const auto& folder : folders) {
        std::error_code ignored;
        for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
            places.manifests.push_back(entry.path().string());
    }
    std::sort(places.manifests.begin(), places.manifests.end());
    for (const char* variable : {"VK_ICD_FILENAMES", "VK_DRIVER_FILES"})
        if (const char* value = std::getenv(variable))
            places.limits.emplace_back(variable, value);
    return places;
}

std::string DriverPlaces::text() const {
    std::string text = manifests.empty() ? "no driver manifest in the usual folders" : "driver manifests seen:";
    for (const std::string& path : manifests)
        text += " " + path;
    for (const auto& [variable, value] : limits)
        text += "; " + variable + " limits the choice to " + (value.empty() ? "nothing" : value);
    return text;
}

Error noVulkan(const std::string& reason) {
    const DriverPlaces places = driverPlaces();
    const std::string seen = places.text();
    std::string remedy;
    for (const auto& limit : places.limits)
        remedy += (remedy.empty() ? "unset " : " and ") + limit.first;
    if (!remedy.empty() && !places.manifests.empty())
        remedy += ", or name one of the manifests seen there";
    else
        remedy += (remedy.empty() ? "" : ", and ") + std::string(kInstallDriver);
    if (seen.find("nvidia") != std::string::npos) // it loads libraries for displays, and is incompatible without
        remedy = "install the packages libgl1 and libegl1, which NVIDIA's driver needs without a display, too; or " + remedy;
    return Error(ErrorKind::Device, "there is no Vulkan device: " + reason, seen, remedy);
}

VKAPI_ATTR VkBool32 VKAPI_CALL onMessage(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    auto& log = *static_cast<ValidationLog*>(user);
    const std::lock_guard lock(log.mutex);
    log.messages.emplace_back(data->pMessage);
    return VK_FALSE;
}

template <class Properties, class Name> bool contains(const Properties& all, Name Properties::value_type::*name, const char* wanted) {
    return std::any_of(all.begin(), all.end(), [&](const auto& p) { return std::strcmp((p.*name).data(), wanted) == 0; });
}

// Mesa 25 takes compiled code from its cache on disk without asking for which LP_NATIVE_VECTOR_WIDTH it was compiled: results are wrong, or the
// process crashes, now or in a later run without the variable. So code for a width of the user's choice stays out of the cache.
void keepOddWidthsOutOfTheCache() {
    if (std::getenv("LP_NATIVE_VECTOR_WIDTH"))
        setenv("MESA_SHADER_CACHE_DISABLE", "true", 0); // whoever has set it knows better
}

std::string versionText(std::uint32_t version) {
    return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version));
}

std::string typeText(vk::PhysicalDeviceType type) {
    switch (type) {
    case vk::PhysicalDeviceType::eCpu: return "cpu";
    case vk::PhysicalDeviceType::eIntegratedGpu: return "integrated";
    case vk::PhysicalDeviceType::eDiscreteGpu: return "discrete";
    case vk::PhysicalDeviceType::eVirtualGpu: return "virtual";
    default: return "other";
    }
}

} // namespace

bool environmentFlag(const char* name) {
    const char* value = std::getenv(name);
    return value && *value && std::strcmp(value, "0") != 0;
}

Instance::~Instance() {
    if (log)
        for (const std::string& message : log->messages)
            logWarn("Vulkan validation: " + message);
}

void Instance::throwValidationMessages() {
    if (!log)
        return;
    const std::lock_guard lock(log->mutex);
    if (log->messages.empty())
        return;
    std::string all;
    for (const std::string& message : log->messages)
        all += message + "\n";
    log->messages.clear();
    throw Error(ErrorKind::Device, "Vulkan validation failed", all, "this is a defect of the program; please report it");
}

Validation validationAsked() {
    if (!environmentFlag("CMPG_VALIDATION"))
        return Validation::None;
    return std::strcmp(std::getenv("CMPG_VALIDATION"), "gpu") == 0 ? Validation::Kernels : Validation::Calls;
}

std::unique_ptr<Instance> createInstance(Validation validation, std::span<const char* const> required) try {
    keepOddWidthsOutOfTheCache(); // before a driver is loaded
    auto instance = std::make_unique<Instance>();
    const auto extensions = instance->context.enumerateInstanceExtensionProperties();
    std::vector<const char*> layers, enabled(required.begin(), required.end());
    if (contains(extensions, &vk::ExtensionProperties::extensionName, VK_EXT_DEBUG_UTILS_EXTENSION_NAME)) {
        instance->debugUtils = true;
        enabled.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    }
    const bool validates = validation != Validation::None;
    if (validates) {
        if (!instance->debugUtils ||
            !contains(instance->context.enumerateInstanceLayerProperties(), &vk::LayerProperties::layerName, kValidationLayer))
            throw Error(ErrorKind::Device, "the Vulkan validation layers are not installed", "validation was asked for",
                        "install the package vulkan-validationlayers, or unset CMPG_VALIDATION");
        layers.push_back(kValidationLayer);
        enabled.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
        instance->log = std::make_unique<ValidationLog>();
    }
    const vk::ApplicationInfo application("cmpg-vk", 0, "cmpg-vk", 0, kApiVersion);
    using Look = vk::ValidationFeatureEnableEXT;
    const std::vector<Look> looks = validation == Validation::Kernels ? std::vector{Look::eGpuAssisted, Look::eGpuAssistedReserveBindingSlot, Look::eSynchronizationValidation}
                                                                      : std::vector{Look::eSynchronizationValidation};
    vk::StructureChain<vk::InstanceCreateInfo, vk::DebugUtilsMessengerCreateInfoEXT, vk::ValidationFeaturesEXT> create(
        {{}, &application, layers, enabled},
        {{},
         vk::DebugUtilsMessageSeverityFlagBitsEXT::eError | vk::DebugUtilsMessageSeverityFlagBitsEXT::eWarning,
         vk::DebugUtilsMessageTypeFlagBitsEXT::eValidation,
         onMessage,
         instance->log.get()},
        {looks, {}});
    if (!validates) {
        create.unlink<vk::DebugUtilsMessengerCreateInfoEXT>();
        create.unlink<vk::ValidationFeaturesEXT>();
    }
    instance->handle = instance->context.createInstance(create.get());
    if (validates) {
        auto messenger = create.get<vk::DebugUtilsMessengerCreateInfoEXT>();
        messenger.pNext = nullptr;
        instance->messenger = instance->handle.createDebugUtilsMessengerEXT(messenger);
    }
    return instance;
} catch (const vk::SystemError& error) {
    throw noVulkan(error.what());
} catch (const Error&) {
    throw;
} catch (const std::runtime_error& error) { // the loader library itself is missing
    throw Error(ErrorKind::Device, std::string("there is no Vulkan device: ") + error.what(), "", std::string("install the package libvulkan1, the loader, and ") + kInstallDriver);
}

std::vector<vk::raii::PhysicalDevice> physicalDevices(const Instance& instance) {
    std::vector<vk::raii::PhysicalDevice> devices;
    try {
        devices = instance.handle.enumeratePhysicalDevices();
    } catch (const vk::SystemError& error) {
        throw noVulkan(error.what());
    }
    if (devices.empty())
        throw noVulkan("the loader found none");
    return devices;
}

std::optional<std::uint32_t> computeQueueFamily(const vk::raii::PhysicalDevice& device) {
    const auto families = device.getQueueFamilyProperties();
    for (std::uint32_t i = 0; i < families.size(); ++i)
        if (families[i].queueFlags & vk::QueueFlagBits::eCompute)
            return i;
    return std::nullopt;
}

bool readsStorageTexels(const vk::raii::PhysicalDevice& device) {
    if (device.getProperties().limits.maxPerStageDescriptorStorageImages < kStorageTexelBuffers)
        return false;
    return std::ranges::all_of(std::array{Texel::Rgba32f, Texel::Rgba32ui, Texel::R32f, Texel::R32ui}, [&](Texel texel) {
        return bool(device.getFormatProperties(texelFormat(texel)).bufferFeatures & vk::FormatFeatureFlagBits::eStorageTexelBuffer);
    });
}

bool isLavapipe(const vk::raii::PhysicalDevice& device) {
    const auto chain = device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties>();
    return chain.get<vk::PhysicalDeviceDriverProperties>().driverID == vk::DriverId::eMesaLlvmpipe;
}

DeviceInfo describe(const vk::raii::PhysicalDevice& device) {
    const vk::PhysicalDeviceProperties basic = device.getProperties();
    DeviceInfo info;
    info.name = basic.deviceName.data();
    info.type = typeText(basic.deviceType);
    info.maxStorageBufferRange = basic.limits.maxStorageBufferRange;
    info.maxTexelBufferElements = basic.limits.maxTexelBufferElements;

    std::ostringstream missing;
    const auto require = [&](bool present, const std::string& what) {
        if (!present)
            missing << (missing.tellp() > 0 ? ", " : "") << what;
    };
    require(basic.apiVersion >= kApiVersion, "Vulkan 1.3 (it has " + versionText(basic.apiVersion) + ")");
    require(computeQueueFamily(device).has_value(), "a compute queue");
    if (basic.apiVersion >= kApiVersion) { // the structures below are 1.2's and 1.3's
        const auto properties = device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceVulkan11Properties,
                                                      vk::PhysicalDeviceVulkan12Properties>();
        const auto features = device.getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features,
                                                  vk::PhysicalDeviceVulkan13Features>();
        const auto& v11 = properties.get<vk::PhysicalDeviceVulkan11Properties>();
        const auto& v12 = properties.get<vk::PhysicalDeviceVulkan12Properties>();
        const auto& features10 = features.get<vk::PhysicalDeviceFeatures2>().features;
        const auto& features12 = features.get<vk::PhysicalDeviceVulkan12Features>();
        const auto& features13 = features.get<vk::PhysicalDeviceVulkan13Features>();
        info.driver = v12.driverName.data();
        if (v12.driverInfo[0])
            info.driver += std::string(" ") + v12.driverInfo.data();
        info.subgroupSize = v11.subgroupSize;
        info.int64Atomics = features10.shaderInt64 && features12.shaderBufferInt64Atomics;
        info.float64 = features10.shaderFloat64;

        // All that is required beyond Vulkan 1.0; Device enables the same.
        constexpr auto subgroup =
            vk::SubgroupFeatureFlagBits::eBasic | vk::SubgroupFeatureFlagBits::eBallot | vk::SubgroupFeatureFlagBits::eArithmetic;
        require(features12.scalarBlockLayout, "scalarBlockLayout");
        require(features13.maintenance4, "maintenance4"); // the compiler writes LocalSizeId
        require((v11.subgroupSupportedStages & vk::ShaderStageFlagBits::eCompute) &&
                    (v11.subgroupSupportedOperations & subgroup) == subgroup,
                "subgroup ballot and arithmetic in compute");
    }
    if (!info.int64Atomics || info.maxTexelBufferElements < kMinTexelElements)
        info.variant = KernelVariant::Portable;
    else if (info.type == "cpu" && readsStorageTexels(device))
        info.variant = KernelVariant::Cpu;
    const std::uint32_t buffers = info.variant == KernelVariant::Portable ? kStorageBuffersPortable : kStorageBuffers;
    require(basic.limits.maxPerStageDescriptorStorageBuffers >= buffers,
            std::to_string(buffers) + " storage buffers in a kernel (it has " + std::to_string(basic.limits.maxPerStageDescriptorStorageBuffers) + ")");
    info.missing = missing.str();
    info.usable = info.missing.empty();
    return info;
}

} // namespace cmpg

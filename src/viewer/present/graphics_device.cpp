// The Vulkan device that draws and presents.
#include "viewer/present/graphics_device.h"

#include <GLFW/glfw3.h>

namespace cmpg::viewer {
namespace {

std::vector<const char*> windowExtensions() {
    std::uint32_t count = 0;
    const char** const names = glfwGetRequiredInstanceExtensions(&count);
    if (!names)
        throw Error(ErrorKind::Device, "Vulkan cannot draw into windows here", "the driver or the Vulkan loader has no surfaces for this window system",
                    kHeadlessRemedy);
    return {names, names + count};
}

// A queue that draws and presents; all devices worth a window have one that does both.
std::optional<std::uint32_t> presentingFamily(const vk::raii::PhysicalDevice& device, vk::SurfaceKHR surface) {
    bool swapchain = false;
    for (const auto& extension : device.enumerateDeviceExtensionProperties())
        swapchain = swapchain || std::string_view(extension.extensionName.data()) == VK_KHR_SWAPCHAIN_EXTENSION_NAME;
    if (!swapchain)
        return std::nullopt;
    const auto families = device.getQueueFamilyProperties();
    for (std::uint32_t i = 0; i < families.size(); ++i)
        if ((families[i].queueFlags & vk::QueueFlagBits::eGraphics) && device.getSurfaceSupportKHR(i, surface))
            return i;
    return std::nullopt;
}

} // namespace

GraphicsDevice::GraphicsDevice(GLFWwindow* glfw, const std::string& select) : window(glfw) {
    instance = createInstance(validationAsked(), windowExtensions());
    VkSurfaceKHR raw = VK_NULL_HANDLE;
    if (glfwCreateWindowSurface(static_cast<VkInstance>(*instance->handle), window, nullptr, &raw) != VK_SUCCESS)
        throw Error(ErrorKind::Device, "Vulkan cannot draw into a window of this display", "the driver does not support the display", kHeadlessRemedy);
    surface = vk::raii::SurfaceKHR(instance->handle, raw);

    std::vector<vk::raii::PhysicalDevice> devices = physicalDevices(*instance);
    std::vector<DeviceInfo> infos;
    infos.reserve(devices.size());
    for (const auto& candidate : devices)
        infos.push_back(describe(candidate));
    std::vector<std::size_t> order{selectDevice(infos, select)}; // pictures travel through host memory, so another will do
    for (std::size_t i = 0; i < devices.size(); ++i)
        if (i != order.front())
            order.push_back(i);
    std::optional<std::uint32_t> family;
    for (std::size_t i = 0; i < order.size() && !family; ++i) {
        family = presentingFamily(devices[order[i]], *surface);
        if (family)
            physical = devices[order[i]];
    }
    if (!family)
        throw Error(ErrorKind::Device, "no Vulkan device can show images on this display",
                    "the devices compute, but their drivers do not present here", kHeadlessRemedy);
    queueFamily = *family;
    maxEdge = physical.getProperties().limits.maxImageDimension2D;

    translating("creating the device of the window", [&] {
        const float priority = 1;
        const vk::DeviceQueueCreateInfo queueInfo({}, queueFamily, 1, &priority);
        const char* const extension = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
        vk::StructureChain<vk::DeviceCreateInfo, vk::PhysicalDeviceVulkan12Features, vk::PhysicalDeviceVulkan13Features> chain;
        chain.get<vk::DeviceCreateInfo>().setQueueCreateInfos(queueInfo).setPEnabledExtensionNames(extension);
        chain.get<vk::PhysicalDeviceVulkan12Features>().scalarBlockLayout = true;
        chain.get<vk::PhysicalDeviceVulkan13Features>().maintenance4 = true;
        device = physical.createDevice(chain.get<vk::DeviceCreateInfo>());
        queue = device.getQueue(queueFamily, 0);
        commandPool = device.createCommandPool({vk::CommandPoolCreateFlagBits::eResetCommandBuffer, queueFamily});
    });
}

vk::raii::DeviceMemory GraphicsDevice::allocate(const vk::MemoryRequirements& needs, vk::MemoryPropertyFlags flags) const {
    const vk::PhysicalDeviceMemoryProperties memory = physical.getMemoryProperties();
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i)
        if ((needs.memoryTypeBits & (1u << i)) && (memory.memoryTypes[i].propertyFlags & flags) == flags)
            return device.allocateMemory({needs.size, i});
    throw Error(ErrorKind::Device, "the device of the window has no memory of the kind that is needed");
}

} // namespace cmpg::viewer

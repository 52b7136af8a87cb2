// The images a window shows, in turns, and the render pass that draws into one of them.
#include "viewer/present/swapchain.h"

#include <GLFW/glfw3.h>
#include <algorithm>

namespace cmpg::viewer {
namespace {

// Eight bits without conversion: the shaders encode, as they do for files, and the interface is drawn in encoded colours.
vk::SurfaceFormatKHR chooseFormat(const GraphicsDevice& device) {
    const auto formats = device.physical.getSurfaceFormatsKHR(*device.surface);
    for (const vk::Format wanted : {vk::Format::eB8G8R8A8Unorm, vk::Format::eR8G8B8A8Unorm, vk::Format::eA8B8G8R8UnormPack32})
        for (const vk::SurfaceFormatKHR& format : formats)
            if (format.format == wanted && format.colorSpace == vk::ColorSpaceKHR::eSrgbNonlinear)
                return format;
    throw Error(ErrorKind::Device, "the display takes no images of eight bits a channel", "an unusual display", kHeadlessRemedy);
}

vk::raii::RenderPass makeRenderPass(const GraphicsDevice& device, vk::Format format) {
    const vk::AttachmentDescription color({}, format, vk::SampleCountFlagBits::e1, vk::AttachmentLoadOp::eClear, vk::AttachmentStoreOp::eStore,
                                          vk::AttachmentLoadOp::eDontCare, vk::AttachmentStoreOp::eDontCare, vk::ImageLayout::eUndefined,
                                          vk::ImageLayout::ePresentSrcKHR);
    const vk::AttachmentReference reference(0, vk::ImageLayout::eColorAttachmentOptimal);
    const vk::SubpassDescription subpass({}, vk::PipelineBindPoint::eGraphics, {}, reference);
    // The image is free when the semaphore says so, which color output waits for; its change of layout must not come earlier.
    const vk::SubpassDependency dependency(VK_SUBPASS_EXTERNAL, 0, vk::PipelineStageFlagBits::eColorAttachmentOutput,
                                           vk::PipelineStageFlagBits::eColorAttachmentOutput, {}, vk::AccessFlagBits::eColorAttachmentWrite);
    return device.device.createRenderPass({{}, color, subpass, dependency});
}

} // namespace

Swapchain::Swapchain(const GraphicsDevice& device)
    : device_(device), format_(chooseFormat(device)), renderPass_(makeRenderPass(device, format_.format)) {
}

vk::Extent2D Swapchain::wantedExtent(const vk::SurfaceCapabilitiesKHR& capabilities) const {
    if (capabilities.currentExtent.width != ~0u)
        return capabilities.currentExtent;
    int width = 0, height = 0; // the surface takes the size of its images
    glfwGetFramebufferSize(device_.window, &width, &height);
    if (width == 0 || height == 0)
        return {0, 0};
    return {std::clamp(std::uint32_t(width), capabilities.minImageExtent.width, capabilities.maxImageExtent.width),
            std::clamp(std::uint32_t(height), capabilities.minImageExtent.height, capabilities.maxImageExtent.height)};
}

bool Swapchain::fit() {
    const vk::SurfaceCapabilitiesKHR capabilities = device_.physical.getSurfaceCapabilitiesKHR(*device_.surface);
    const vk::Extent2D wanted = wantedExtent(capabilities);
    if (wanted.width == 0 || wanted.height == 0)
        return false;
    if (!outdated_ && wanted == extent_)
        return true;
    device_.device.waitIdle(); // what is shown may still be read
    constexpr std::uint32_t kWanted = 3; // one shown, one waiting, one drawn
    std::uint32_t count = std::max(kWanted, capabilities.minImageCount);
    if (capabilities.maxImageCount > 0)
        count = std::min(count, capabilities.maxImageCount);
    const auto alpha = (capabilities.supportedCompositeAlpha & vk::CompositeAlphaFlagBitsKHR::eOpaque) ? vk::CompositeAlphaFlagBitsKHR::eOpaque
                                                                                                       : vk::CompositeAlphaFlagBitsKHR::eInherit;
    frames_.clear();
    swapchain_ = device_.device.createSwapchainKHR({{}, *device_.surface, count, format_.format, format_.colorSpace, wanted, 1,
                                                    vk::ImageUsageFlagBits::eColorAttachment, vk::SharingMode::eExclusive, {},
                                                    capabilities.currentTransform, alpha, vk::PresentModeKHR::eFifo, true, *swapchain_});
    for (const VkImage image : swapchain_.getImages()) {
        Frame frame;
        frame.image = image;
        frame.view = device_.device.createImageView(
            {{}, frame.image, vk::ImageViewType::e2D, format_.format, {}, {vk::ImageAspectFlagBits::eColor, 0, 1, 0, 1}});
        frame.framebuffer = device_.device.createFramebuffer({{}, *renderPass_, *frame.view, wanted.width, wanted.height, 1});
        frame.drawn = device_.device.createSemaphore({});
        frames_.push_back(std::move(frame));
    }
    extent_ = wanted;
    outdated_ = false;
    return true;
}

const Swapchain::Frame* Swapchain::acquire(const vk::raii::Semaphore& free) {
    constexpr std::uint64_t kPatience = 200'000'000; // nanoseconds: a window that is covered may get no images
    try {
        const auto [result, index] = swapchain_.acquireNextImage(kPatience, *free);
        if (result == vk::Result::eTimeout || result == vk::Result::eNotReady)
            return nullptr;
        outdated_ = outdated_ || result == vk::Result::eSuboptimalKHR;
        acquired_ = index;
        return &frames_[index];
    } catch (const vk::OutOfDateKHRError&) {
        outdated_ = true;
        return nullptr;
    }
}

void Swapchain::present() {
    try {
        const vk::Result result = device_.queue.presentKHR({*frames_[acquired_].drawn, *swapchain_, acquired_});
        outdated_ = outdated_ || result == vk::Result::eSuboptimalKHR;
    } catch (const vk::OutOfDateKHRError&) {
        outdated_ = true;
    }
}

} // namespace cmpg::viewer

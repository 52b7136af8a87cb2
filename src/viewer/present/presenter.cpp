// Puts frames into a window: images, and the interface over them.
#include "viewer/present/presenter.h"

#include "viewer/present/panel_drawing.h"
#include "viewer/present/swapchain.h"

#include <imgui.h>
#include <backends/imgui_impl_vulkan.h>

namespace cmpg::viewer {

struct Presenter::Impl {
    GraphicsDevice device;
    Swapchain swapchain;
    PanelDrawing panels;
    vk::raii::CommandBuffers commands;
    vk::raii::Semaphore acquired;
    vk::raii::Fence done; // of the frame before: one is in flight at most
    vk::raii::DescriptorPool interfacePool;
    bool interfaceReady = false;

    Impl(GLFWwindow* window, const std::string& select)
        : device(window, select), swapchain(device), panels(device, swapchain.renderPass()),
          commands(device.device, {*device.commandPool, vk::CommandBufferLevel::ePrimary, 1}), acquired(device.device.createSemaphore({})),
          done(device.device.createFence({vk::FenceCreateFlagBits::eSignaled})), interfacePool(makeInterfacePool()) {}

    ~Impl() {
        try {
            device.device.waitIdle();
        } catch (const vk::SystemError&) { // a lost device has nothing to wait for
        }
        closeInterface();
    }

    vk::raii::DescriptorPool makeInterfacePool() const {
        const vk::DescriptorPoolSize size(vk::DescriptorType::eCombinedImageSampler, 4); // the font's, more than once while it changes
        return device.device.createDescriptorPool({vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 4, size});
    }

    // Dear ImGui wants to know the number of swapchain images, for its vertex buffers; more than are used do no harm.
    void openInterface() {
        constexpr std::uint32_t kImages = 4;
        ImGui_ImplVulkan_InitInfo info{};
        info.Instance = static_cast<VkInstance>(*device.instance->handle);
        info.PhysicalDevice = static_cast<VkPhysicalDevice>(*device.physical);
        info.Device = static_cast<VkDevice>(*device.device);
        info.QueueFamily = device.queueFamily;
        info.Queue = static_cast<VkQueue>(*device.queue);
        info.DescriptorPool = static_cast<VkDescriptorPool>(*interfacePool);
        info.MinImageCount = 2;
        info.ImageCount = kImages;
        info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
        info.CheckVkResultFn = [](VkResult result) {
            if (result < 0)
                throw Error(ErrorKind::Device, "drawing the interface: " + vk::to_string(vk::Result(result)));
        };
        ImGui_ImplVulkan_Init(&info, static_cast<VkRenderPass>(swapchain.renderPass()));
        device.runOnce([](const vk::raii::CommandBuffer& c) { ImGui_ImplVulkan_CreateFontsTexture(static_cast<VkCommandBuffer>(*c)); });
        ImGui_ImplVulkan_DestroyFontUploadObjects();
        interfaceReady = true;
    }

    void closeInterface() {
        if (interfaceReady)
            ImGui_ImplVulkan_Shutdown();
        interfaceReady = false;
    }

    void waitForFrame() {
        if (device.device.waitForFences(*done, true, ~std::uint64_t(0)) != vk::Result::eSuccess)
            throw Error(ErrorKind::Device, "the window's frame did not finish");
    }

    void draw(std::span<const PanelQuad> quads) {
        waitForFrame();
        const Swapchain::Frame* const frame = swapchain.acquire(acquired);
        if (!frame)
            return;
        device.device.resetFences(*done);
        const vk::raii::CommandBuffer& c = commands[0];
        c.begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
        panels.upload(c, quads);
        const vk::ClearValue background(vk::ClearColorValue(std::array{0.11f, 0.11f, 0.12f, 1.f}));
        c.beginRenderPass({swapchain.renderPass(), *frame->framebuffer, {{}, swapchain.extent()}, background}, vk::SubpassContents::eInline);
        panels.draw(c, quads, swapchain.extent());
        ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), static_cast<VkCommandBuffer>(*c));
        c.endRenderPass();
        c.end();
        const vk::PipelineStageFlags stage = vk::PipelineStageFlagBits::eColorAttachmentOutput;
        device.queue.submit(vk::SubmitInfo(*acquired, stage, *c, *frame->drawn), *done);
        swapchain.present();
    }
};

Presenter::Presenter(GLFWwindow* window, const std::string& device) {
    translating("opening the window", [&] {
        impl_ = std::make_unique<Impl>(window, device);
        impl_->openInterface();
    });
}

Presenter::~Presenter() = default;

bool Presenter::begin() {
    return translating("fitting the window", [&] {
        impl_->waitForFrame();
        if (!impl_->swapchain.fit())
            return false;
        ImGui_ImplVulkan_NewFrame();
        return true;
    });
}

void Presenter::end(std::span<const PanelQuad> quads) {
    translating("drawing the window", [&] { impl_->draw(quads); });
    impl_->device.instance->throwValidationMessages();
}

void Presenter::fontsChanged() {
    translating("changing the fonts", [&] {
        impl_->device.device.waitIdle();
        impl_->closeInterface();
        impl_->openInterface();
    });
}

} // namespace cmpg::viewer

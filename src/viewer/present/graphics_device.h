// The Vulkan device that draws and presents. It is another one than that which computes, so that a frame never waits for a pass: a
// device of Mesa's CPU driver has one queue for everything.
#pragma once

#include "vk/instance.h"

struct GLFWwindow;

namespace cmpg::viewer {

struct GraphicsDevice {
    // A device that can present in this window: the one that `select` means as Device::Options::select does, if it can.
    // Error(Device) where none can.
    GraphicsDevice(GLFWwindow* glfw, const std::string& select);

    GLFWwindow* window;
    std::unique_ptr<Instance> instance;
    vk::raii::SurfaceKHR surface{nullptr};
    vk::raii::PhysicalDevice physical{nullptr};
    std::uint32_t queueFamily = 0;
    std::uint32_t maxEdge = 0; // of a two-dimensional image
    vk::raii::Device device{nullptr};
    vk::raii::Queue queue{nullptr};
    vk::raii::CommandPool commandPool{nullptr};

    vk::raii::DeviceMemory allocate(const vk::MemoryRequirements& needs, vk::MemoryPropertyFlags flags) const;
    // Runs what `record` records, and waits.
    template <class Record> void runOnce(Record&& record) const {
        const vk::raii::CommandBuffers commands(device, {*commandPool, vk::CommandBufferLevel::ePrimary, 1});
        commands[0].begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
        record(commands[0]);
        commands[0].end();
        queue.submit(vk::SubmitInfo({}, {}, *commands[0]));
        queue.waitIdle();
    }
};

// What every failure to show a window says at its end.
constexpr const char* kHeadlessRemedy = "work without a window: cmpg-vk --headless COMMAND SCENE ...; cmpg-vk --help lists the commands";

} // namespace cmpg::viewer

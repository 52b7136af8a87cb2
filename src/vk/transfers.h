// Copies between the host and memory that it cannot map.
#pragma once

#include "vk/raw_buffer.h"
#include "vk/vulkan.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace cmpg {

constexpr std::uint64_t kStagingBytes = 8u << 20;

// What goes to the device is copied to a staging buffer at once, and from there by commands that wait for the next submission and begin it: a submission
// of its own takes a discrete device longer than most of these copies. What comes back is waited for, and ends what waited.
class Transfers {
  public:
    using Submit = std::function<void(std::span<const vk::CommandBuffer>)>; // and waits

    // `makeStaging`: a mapped buffer of kStagingBytes.
    Transfers(const vk::raii::Device& device, std::uint32_t queueFamily, std::function<RawBuffer()> makeStaging, Submit submit);

    void clear(vk::Buffer to); // which is new
    void send(vk::Buffer to, std::uint64_t offset, std::span<const std::byte> bytes);

    struct Fetch {
        vk::Buffer from;
        std::uint64_t offset;
        std::span<std::byte> to;
    };
    void fetch(std::span<const Fetch> fetches);

    // The commands that wait, for a submission that begins with them; null: there are none. That submission is waited for before the next call.
    vk::CommandBuffer take();
    // Submits what waits if it touches the buffer, which is about to go.
    void release(vk::Buffer buffer);

  private:
    const vk::raii::CommandBuffer& open();
    void reserve(std::uint64_t bytes); // after those that are used; at most kStagingBytes
    void waitForWrites();              // by the commands recorded so far
    void flush();

    std::function<RawBuffer()> makeStaging_;
    Submit submit_;
    vk::raii::CommandPool pool_;
    vk::raii::CommandBuffers commands_;
    RawBuffer staging_;       // made by the first transfer
    std::uint64_t used_ = 0;  // bytes of it
    bool open_ = false;       // commands wait
    std::vector<vk::Buffer> touched_; // by these
    std::vector<vk::Buffer> written_; // since the last barrier
};

} // namespace cmpg

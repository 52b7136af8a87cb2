// Copies that wait for a submission, and copies that are waited for.
#include "vk/transfers.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace cmpg {
namespace {

using Stage = vk::PipelineStageFlagBits;
using Access = vk::AccessFlagBits;

constexpr std::uint64_t kAlignment = 16; // of a part of the staging buffer

constexpr std::uint64_t aligned(std::uint64_t bytes) { return (bytes + kAlignment - 1) / kAlignment * kAlignment; }

} // namespace

Transfers::Transfers(const vk::raii::Device& device, std::uint32_t queueFamily, std::function<RawBuffer()> makeStaging, Submit submit)
    : makeStaging_(std::move(makeStaging)), submit_(std::move(submit)), pool_(device, {vk::CommandPoolCreateFlagBits::eResetCommandBuffer, queueFamily}),
      commands_(device, {*pool_, vk::CommandBufferLevel::ePrimary, 1}) {}

const vk::raii::CommandBuffer& Transfers::open() {
    const vk::raii::CommandBuffer& commands = commands_[0];
    if (!std::exchange(open_, true)) {
        commands.begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
        const vk::MemoryBarrier earlier(Access::eShaderWrite | Access::eTransferWrite, Access::eTransferRead | Access::eTransferWrite);
        commands.pipelineBarrier(Stage::eComputeShader | Stage::eTransfer, Stage::eTransfer, {}, earlier, nullptr, nullptr);
    }
    return commands;
}

void Transfers::reserve(std::uint64_t bytes) {
    if (!*staging_.buffer)
        staging_ = makeStaging_();
    if (bytes > kStagingBytes - used_)
        flush();
}

void Transfers::waitForWrites() {
    const vk::MemoryBarrier writes(Access::eTransferWrite, Access::eTransferRead | Access::eTransferWrite);
    open().pipelineBarrier(Stage::eTransfer, Stage::eTransfer, {}, writes, nullptr, nullptr);
    written_.clear();
}

void Transfers::clear(vk::Buffer to) {
    open().fillBuffer(to, 0, VK_WHOLE_SIZE, 0);
    touched_.push_back(to);
    written_.push_back(to);
}

void Transfers::send(vk::Buffer to, std::uint64_t offset, std::span<const std::byte> bytes) {
    for (std::uint64_t done = 0; done < bytes.size();) {
        const std::uint64_t part = std::min<std::uint64_t>(bytes.size() - done, kStagingBytes);
        reserve(part);
        std::memcpy(staging_.mapped + used_, bytes.data() + done, part);
        if (std::find(written_.begin(), written_.end(), to) != written_.end())
            waitForWrites();
        open().copyBuffer(*staging_.buffer, to, vk::BufferCopy(used_, offset + done, part));
        touched_.push_back(to);
        written_.push_back(to);
        used_ = aligned(used_ + part);
        done += part;
    }
}

void Transfers::fetch(std::span<const Fetch> fetches) {
    struct Part {
        std::uint64_t at; // in the staging buffer
        std::span<std::byte> to;
    };
    std::vector<Part> parts;
    const auto finish = [&] {
        if (parts.empty())
            return;
        const vk::MemoryBarrier toHost(Access::eTransferWrite, Access::eHostRead);
        open().pipelineBarrier(Stage::eTransfer, Stage::eHost, {}, toHost, nullptr, nullptr);
        flush();
        for (const Part& part : parts)
            std::memcpy(part.to.data(), staging_.mapped + part.at, part.to.size());
        parts.clear();
    };
    for (const Fetch& wanted : fetches)
        for (std::uint64_t done = 0; done < wanted.to.size();) {
            const std::uint64_t part = std::min<std::uint64_t>(wanted.to.size() - done, kStagingBytes);
            if (part > kStagingBytes - used_)
                finish();
            reserve(part);
            if (std::find(written_.begin(), written_.end(), wanted.from) != written_.end())
                waitForWrites();
            open().copyBuffer(wanted.from, *staging_.buffer, vk::BufferCopy(wanted.offset + done, used_, part));
            parts.push_back({used_, wanted.to.subspan(done, part)});
            used_ = aligned(used_ + part);
            done += part;
        }
    finish();
}

vk::CommandBuffer Transfers::take() {
    if (!std::exchange(open_, false))
        return nullptr;
    commands_[0].end();
    used_ = 0;
    touched_.clear();
    written_.clear();
    return *commands_[0];
}

void Transfers::flush() {
    if (const vk::CommandBuffer commands = take())
        submit_({&commands, 1});
}

void Transfers::release(vk::Buffer buffer) {
    if (std::find(touched_.begin(), touched_.end(), buffer) != touched_.end())
        flush();
}

} // namespace cmpg

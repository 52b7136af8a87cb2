// Device buffers: accounting, texel views and host transfers.
#include "vk/device.h"

#include "vk/impl.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <sys/mman.h>
#include <unistd.h>

namespace cmpg {

namespace {

constexpr std::uint64_t roundUp(std::uint64_t value, std::uint64_t multiple) { return (value + multiple - 1) / multiple * multiple; }

void requireRange(const Buffer::Impl& buffer, std::uint64_t offset, std::uint64_t bytes) {
    if (offset > buffer.bytes || bytes > buffer.bytes - offset)
        throw std::out_of_range("transfer of " + std::to_string(bytes) + " bytes at " + std::to_string(offset) + " of '" + buffer.name +
                                "', which has " + std::to_string(buffer.bytes));
}

// Clears memory that the system may not have given yet. It gives pages asked for at once in 0.6 of the time of pages touched one by one, which is most of
// what clearing takes. Where it cannot, they are touched.
void clear(std::byte* memory, std::uint64_t bytes) {
#ifdef MADV_POPULATE_WRITE
    static const auto page = std::uint64_t(::sysconf(_SC_PAGESIZE));
    const auto begin = roundUp(reinterpret_cast<std::uintptr_t>(memory), page), end = (reinterpret_cast<std::uintptr_t>(memory) + bytes) / page * page;
    if (begin < end)
        ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_POPULATE_WRITE);
#endif
    std::memset(memory, 0, bytes);
}

} // namespace

vk::Format texelFormat(Texel texel) {
    switch (texel) {
    case Texel::Rgba32f: return vk::Format::eR32G32B32A32Sfloat;
    case Texel::Rgba32ui: return vk::Format::eR32G32B32A32Uint;
    case Texel::R32f: return vk::Format::eR32Sfloat;
    case Texel::R32ui: return vk::Format::eR32Uint;
    case Texel::None: break;
    }
    return vk::Format::eUndefined;
}

vk::BufferUsageFlags texelUsage(KernelVariant variant) {
    return variant == KernelVariant::Cpu ? vk::BufferUsageFlagBits::eStorageTexelBuffer : vk::BufferUsageFlagBits::eUniformTexelBuffer;
}

std::uint64_t texelBytes(Texel texel) { return texel == Texel::R32f || texel == Texel::R32ui ? 4 : 16; }

std::uint64_t paddedTexelBytes(std::uint64_t bytes) {
    bytes = roundUp(bytes, 256);
    while (std::has_single_bit(bytes) || (bytes & 0xff00) == 0)
        bytes += 256;
    return bytes;
}

Buffer::Buffer(Device& device, std::string name, std::uint64_t bytes, MemoryKind kind, Texel texel) {
    auto impl = std::make_unique<Impl>();
    impl->name = std::move(name);
    impl->bytes = std::max<std::uint64_t>(roundUp(bytes, 16), 16);
    impl->kind = kind;
    impl->texel = texel;
    using Usage = vk::BufferUsageFlagBits;
    vk::BufferUsageFlags usage = Usage::eStorageBuffer | Usage::eUniformBuffer | Usage::eIndirectBuffer | Usage::eTransferSrc | Usage::eTransferDst;
    if (texel != Texel::None)
        usage |= texelUsage(device.variant());
    const std::uint64_t padded = texel == Texel::None ? impl->bytes : paddedTexelBytes(impl->bytes);
    const std::uint64_t created = padded <= device.impl().maxAllocation ? padded : impl->bytes; // the largest buffer goes without
    impl->raw = device.impl().allocate(impl->name, created, usage, Device::Impl::Place::Device);
    impl->device = &device.impl(); // from here on the destructor takes it off the accounts again

    MemoryUse& memory = device.impl().memory;
    const std::uint64_t allocated = impl->raw.allocated;
    memory.buffers[impl->name] += allocated;
    memory.peak = std::max(memory.peak, memory.current += allocated);
    memory.peakByKind[std::size_t(kind)] = std::max(memory.peakByKind[std::size_t(kind)], memory.byKind[std::size_t(kind)] += allocated);

    if (impl->raw.mapped)
        clear(impl->raw.mapped, created);
    else
        device.impl().transfers->clear(*impl->raw.buffer);
    impl_ = std::move(impl);
}

Buffer::Buffer() noexcept = default;
Buffer::~Buffer() = default;
Buffer::Buffer(Buffer&&) noexcept = default;
Buffer& Buffer::operator=(Buffer&&) noexcept = default;

Buffer::Impl::~Impl() {
    if (!device)
        return;
    try {
        device->transfers->release(*raw.buffer);
    } catch (const std::exception&) { // the device is lost, as the next submission will say
    }
    MemoryUse& memory = device->memory;
    memory.current -= raw.allocated;
    memory.byKind[std::size_t(kind)] -= raw.allocated;
    const auto entry = memory.buffers.find(name);
    if ((entry->second -= raw.allocated) == 0)
        memory.buffers.erase(entry);
}

std::uint64_t Buffer::size() const { return impl_ ? impl_->bytes : 0; }

void Buffer::upload(std::span<const std::byte> bytes, std::uint64_t offset) {
    requireRange(*impl_, offset, bytes.size());
    if (impl_->raw.mapped) {
        std::memcpy(impl_->raw.mapped + offset, bytes.data(), bytes.size());
        return;
    }
    impl_->device->transfers->send(*impl_->raw.buffer, offset, bytes);
}

void Buffer::download(std::span<std::byte> bytes, std::uint64_t offset) const {
    const Download one{this, bytes, offset};
    cmpg::download({&one, 1});
}

void download(std::span<const Download> downloads) {
    std::vector<Transfers::Fetch> fetches;
    Device::Impl* device = nullptr;
    for (const auto& [from, to, offset] : downloads) {
        const Buffer::Impl& buffer = *from->impl();
        requireRange(buffer, offset, to.size());
        if (buffer.raw.mapped)
            std::memcpy(to.data(), buffer.raw.mapped + offset, to.size());
        else
            fetches.push_back({*buffer.raw.buffer, offset, to}), device = buffer.device;
    }
    if (device)
        device->transfers->fetch(fetches);
}

vk::BufferView Buffer::Impl::view(std::uint64_t offset, std::uint64_t range) {
    const std::uint64_t elements = range / texelBytes(texel);
    if (elements > device->info.maxTexelBufferElements)
        throw Error(ErrorKind::Device,
                    "'" + name + "' has " + std::to_string(elements) + " texels, but '" + device->info.name + "' reads at most " +
                        std::to_string(device->info.maxTexelBufferElements),
                    "the scene is too large for this device", "reduce the scene, or set CMPG_PORTABLE=1");
    auto found = views.find({offset, range});
    if (found == views.end()) {
        // Padding, where the buffer has room for it, only keeps lavapipe from compiling again; kernels do not read there.
        const std::uint64_t padded = std::min(paddedTexelBytes(range), paddedTexelBytes(bytes) - offset);
        const bool fits = padded / texelBytes(texel) <= device->info.maxTexelBufferElements && offset + padded <= device->maxAllocation;
        found = views
                    .emplace(std::pair(offset, range),
                             device->device.createBufferView({{}, *raw.buffer, texelFormat(texel), offset, fits ? padded : range}))
                    .first;
    }
    return *found->second;
}

} // namespace cmpg

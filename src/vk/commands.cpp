// Recording, submission and timing of commands.
#include "vk/device.h"

#include "vk/impl.h"
#include "vk/spirv.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

namespace cmpg {

namespace {

constexpr std::uint32_t kMaxGroups = 65535; // per dimension; what every device allows
constexpr std::uint32_t kQueriesPerPool = 512;
constexpr std::uint32_t kSetsPerPool = 256;

using Stage = vk::PipelineStageFlagBits;
using Access = vk::AccessFlagBits;

// x and y of a dispatch of `groups` workgroups, as even as possible. shaders/lib/dispatch.glsl has the same for indirect counts.
std::pair<std::uint32_t, std::uint32_t> fold(std::uint64_t groups) {
    if (groups <= kMaxGroups)
        return {std::uint32_t(groups), 1};
    const std::uint64_t rows = (groups + kMaxGroups - 1) / kMaxGroups;
    return {std::uint32_t((groups + rows - 1) / rows), std::uint32_t(rows)};
}

} // namespace

struct Commands::Impl {
    Device::Impl& device;
    vk::raii::CommandPool pool;
    vk::raii::CommandBuffers buffers;
    enum class State { Empty, Recording, Recorded } state = State::Empty;
    std::vector<vk::raii::DescriptorPool> setPools; // the last is being allocated from
    struct Dispatch {
        std::string_view kernel; // its name in the table of embedded kernels
        bool timed;
        std::uint32_t begin = 0, end = 0; // queries, where it is timed
    };
    std::vector<Dispatch> dispatches;
    std::vector<vk::raii::QueryPool> queryPools;
    std::uint32_t queries = 0;      // timestamps written
    bool otherCommandSince = true;  // the last timestamp is not where the next dispatch begins

    explicit Impl(Device::Impl& owner)
        : device(owner), pool(owner.device, vk::CommandPoolCreateInfo({}, owner.queueFamily)),
          buffers(owner.device, {*pool, vk::CommandBufferLevel::ePrimary, 1}) {}

    const vk::raii::CommandBuffer& recording();
    void barrier();
    vk::DescriptorSet allocateSet(vk::DescriptorSetLayout layout);
    vk::DescriptorSet bind(const Kernel::Impl& kernel, const Bindings& bindings);
    template <class Launch>
    void dispatch(const Kernel::Impl& kernel, const Bindings& bindings, std::span<const std::byte> push, Launch launch);
    std::uint32_t timestamp();
    void collectTimes();
};

const vk::raii::CommandBuffer& Commands::Impl::recording() {
    if (state == State::Recorded)
        throw std::logic_error("commands were submitted: nothing more can be recorded");
    if (state == State::Empty) {
        buffers[0].begin({});
        state = State::Recording;
        barrier(); // what earlier submissions wrote
    }
    return buffers[0];
}

void Commands::Impl::barrier() {
    // Reads of uniform buffers are no shader reads: GPUs cache them apart.
    const vk::MemoryBarrier all(Access::eShaderWrite | Access::eTransferWrite, Access::eShaderRead | Access::eShaderWrite | Access::eUniformRead |
                                                                                   Access::eTransferRead | Access::eTransferWrite |
                                                                                   Access::eIndirectCommandRead);
    buffers[0].pipelineBarrier(Stage::eComputeShader | Stage::eTransfer,
                               Stage::eComputeShader | Stage::eTransfer | Stage::eDrawIndirect, {}, all, nullptr, nullptr);
}

vk::DescriptorSet Commands::Impl::allocateSet(vk::DescriptorSetLayout layout) {
    for (;;) {
        if (!setPools.empty()) {
            try {
                // Plain handles: all sets of a pool are freed with it.
                const vk::DescriptorSetAllocateInfo allocate(*setPools.back(), layout);
                return (*device.device).allocateDescriptorSets(allocate, *device.device.getDispatcher())[0];
            } catch (const vk::OutOfPoolMemoryError&) {
            } catch (const vk::FragmentedPoolError&) {
            }
        }
        const std::array sizes{vk::DescriptorPoolSize(vk::DescriptorType::eStorageBuffer, kSetsPerPool * 16),
                               vk::DescriptorPoolSize(vk::DescriptorType::eUniformBuffer, kSetsPerPool * 5),
                               vk::DescriptorPoolSize(device.variant == KernelVariant::Cpu ? vk::DescriptorType::eStorageTexelBuffer
                                                                                           : vk::DescriptorType::eUniformTexelBuffer,
                                                      kSetsPerPool * 8)};
        setPools.push_back(device.device.createDescriptorPool({{}, kSetsPerPool, sizes}));
    }
}

vk::DescriptorSet Commands::Impl::bind(const Kernel::Impl& kernel, const Bindings& bindings) {
    const auto& declared = kernel.interface.bindings;
    const vk::DescriptorSet set = allocateSet(*kernel.setLayout);
    std::vector<vk::DescriptorBufferInfo> ranges(declared.size());
    std::vector<vk::BufferView> views(declared.size());
    std::vector<vk::WriteDescriptorSet> writes;
    for (std::size_t i = 0; i < declared.size(); ++i) {
        const auto [number, resource, oneNumber] = declared[i];
        const bool uniform = resource == KernelInterface::Resource::Uniform;
        const bool texel = resource != KernelInterface::Resource::Storage && !uniform;
        const bool texelFloat = resource == KernelInterface::Resource::TexelFloat || resource == KernelInterface::Resource::StorageTexelFloat;
        const Bindings::Range& range = bindings.at(number);
        Buffer::Impl* const buffer = range.buffer ? range.buffer->impl() : nullptr;
        if (!buffer) {
            ranges[i] = vk::DescriptorBufferInfo(*device.dummy.buffer, 0, VK_WHOLE_SIZE);
            if (texel)
                views[i] = *device.dummyViews.at(texelFloat ? (oneNumber ? Texel::R32f : Texel::Rgba32f) : oneNumber ? Texel::R32ui : Texel::Rgba32ui);
        } else {
            if (range.offset % 256 != 0 || range.offset >= buffer->bytes || range.bytes > buffer->bytes - range.offset)
                throw std::logic_error("binding " + std::to_string(number) + " of '" + kernel.name + "': wrong range of '" +
                                       buffer->name + "'");
            const std::uint64_t bytes = range.bytes ? range.bytes : buffer->bytes - range.offset;
            if (texel) {
                const bool isFloat = buffer->texel == Texel::Rgba32f || buffer->texel == Texel::R32f;
                if (buffer->texel == Texel::None || isFloat != texelFloat)
                    throw std::logic_error("kernel '" + kernel.name + "' reads '" + buffer->name + "' as texels of another format");
                views[i] = buffer->view(range.offset, bytes);
            } else if (bytes > (uniform ? device.limits.maxUniformBufferRange : device.info.maxStorageBufferRange)) {
                throw Error(ErrorKind::Device,
                            "'" + buffer->name + "' has " + std::to_string(bytes) + " bytes, but '" + device.info.name +
                                "' binds at most " + std::to_string(device.info.maxStorageBufferRange) + " at once",
                            "the scene or the passes are too large for this device", "lower the memory budget or the size of the scene", {"memory"});
            } else {
                ranges[i] = vk::DescriptorBufferInfo(*buffer->raw.buffer, range.offset, bytes);
            }
        }
        vk::WriteDescriptorSet& write = writes.emplace_back(set, number, 0, 1);
        write.descriptorType = descriptorType(resource);
        write.pBufferInfo = &ranges[i];
        write.pTexelBufferView = &views[i];
    }
    device.device.updateDescriptorSets(writes, nullptr);
    return set;
}

template <class Launch>
void Commands::Impl::dispatch(const Kernel::Impl& kernel, const Bindings& bindings, std::span<const std::byte> push, Launch launch) {
    // C++ may pad the end of a struct to its alignment; a larger difference is another struct.
    const std::uint32_t pushBytes = kernel.interface.pushBytes;
    if (push.size() < pushBytes || push.size() >= pushBytes + 16)
        throw std::logic_error("kernel '" + kernel.name + "' takes " + std::to_string(pushBytes) + " bytes of push constants, not " +
                               std::to_string(push.size()));
    const vk::raii::CommandBuffer& commands = recording();
    if (device.instance->debugUtils)
        commands.beginDebugUtilsLabelEXT({kernel.name.c_str()});
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *kernel.pipeline);
    if (!kernel.interface.bindings.empty())
        commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *kernel.pipelineLayout, 0, bind(kernel, bindings), nullptr);
    if (pushBytes)
        commands.pushConstants<std::byte>(*kernel.pipelineLayout, vk::ShaderStageFlagBits::eCompute, 0,
                                          vk::ArrayProxy<const std::byte>(pushBytes, push.data()));

    Dispatch launched{.kernel = findKernel(kernel.name).name, .timed = device.timesKernels && device.timestampMask};
    if (launched.timed)
        launched.begin = otherCommandSince ? timestamp() : queries - 1; // where the dispatch before it ended: timestamps take their time
    launch(commands);
    if (launched.timed)
        launched.end = timestamp();
    otherCommandSince = !launched.timed;
    dispatches.push_back(launched);
    if (device.instance->debugUtils)
        commands.endDebugUtilsLabelEXT();
}

std::uint32_t Commands::Impl::timestamp() {
    if (queries / kQueriesPerPool == queryPools.size())
        queryPools.push_back(device.device.createQueryPool({{}, vk::QueryType::eTimestamp, kQueriesPerPool}));
    const vk::QueryPool current = *queryPools[queries / kQueriesPerPool];
    if (queries % kQueriesPerPool == 0)
        buffers[0].resetQueryPool(current, 0, kQueriesPerPool);
    buffers[0].writeTimestamp(Stage::eBottomOfPipe, current, queries % kQueriesPerPool);
    return queries++;
}

void Commands::Impl::collectTimes() {
    std::vector<std::uint64_t> ticks(queries);
    for (std::uint32_t first = 0; first < queries; first += kQueriesPerPool) {
        const std::uint32_t count = std::min(queries - first, kQueriesPerPool);
        const auto part = queryPools[first / kQueriesPerPool]
                              .getResults<std::uint64_t>(0, count, count * sizeof(std::uint64_t), sizeof(std::uint64_t),
                                                         vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWait)
                              .second;
        std::copy(part.begin(), part.end(), ticks.begin() + first);
    }
    for (const Dispatch& d : dispatches) {
        KernelTime& time = device.kernelTimes[std::string(d.kernel)];
        ++time.calls;
        if (d.timed)
            time.seconds += double((ticks[d.end] - ticks[d.begin]) & device.timestampMask) * device.limits.timestampPeriod * 1e-9;
    }
}

Commands::Commands(Device& device)
    : impl_(translating("creating a command buffer", [&] { return std::make_unique<Impl>(device.impl()); })) {}
Commands::~Commands() = default;
Commands::Commands(Commands&&) noexcept = default;

void Commands::dispatchBytes(const Kernel& k, const Bindings& b, std::uint64_t items, std::span<const std::byte> push) {
    const std::uint64_t local = k.localSize();
    const auto [x, y] = fold((items + local - 1) / local);
    // globalIndex() is 32 bits wide; where it wrapped, items would be processed twice.
    if (std::uint64_t(x) * y * local > std::numeric_limits<std::uint32_t>::max() || y > kMaxGroups)
        throw std::logic_error("kernel '" + k.name() + "' was given " + std::to_string(items) + " items at once");
    impl_->dispatch(*k.impl(), b, push, [x = x, y = y](const auto& commands) { commands.dispatch(x, y, 1); });
}

void Commands::dispatchIndirectBytes(const Kernel& k, const Bindings& b, const Buffer& arguments, std::uint64_t offset,
                                     std::span<const std::byte> push) {
    if (offset % 4 != 0 || offset + 12 > arguments.size())
        throw std::logic_error("kernel '" + k.name() + "': wrong offset of the group counts");
    impl_->dispatch(*k.impl(), b, push,
                    [&](const auto& commands) { commands.dispatchIndirect(*arguments.impl()->raw.buffer, offset); });
}

void Commands::fill(const Buffer& buffer, std::uint32_t value) {
    impl_->otherCommandSince = true;
    impl_->recording().fillBuffer(*buffer.impl()->raw.buffer, 0, buffer.size(), value);
}

void Commands::barrier() {
    impl_->recording();
    impl_->barrier();
}

void Commands::submitAndWait() {
    if (impl_->state == Impl::State::Empty)
        return;
    const vk::raii::CommandBuffer& commands = impl_->buffers[0];
    if (impl_->state == Impl::State::Recording) {
        const vk::MemoryBarrier toHost(Access::eShaderWrite | Access::eTransferWrite, Access::eHostRead);
        commands.pipelineBarrier(Stage::eComputeShader | Stage::eTransfer, Stage::eHost, {}, toHost, nullptr, nullptr);
        commands.end();
        impl_->state = Impl::State::Recorded;
    }
    impl_->device.submitAndWait(*commands);
    impl_->collectTimes();
}

Bindings& Bindings::set(std::uint32_t binding, const Buffer& buffer, std::uint64_t offset, std::uint64_t bytes) {
    ranges_.at(binding) = {&buffer, offset, bytes};
    return *this;
}

const Bindings::Range& Bindings::at(std::uint32_t binding) const { return ranges_.at(binding); }

} // namespace cmpg

// One compute pipeline, laid out by what its SPIR-V declares.
#include "vk/device.h"

#include "base/parallel.h"
#include "vk/impl.h"
#include "vk/spirv.h"

#include <algorithm>
#include <functional>
#include <numeric>

namespace cmpg {

namespace {

void requireCapabilities(const Device::Impl& device, const std::string& name, const KernelInterface& interface) {
    const auto refuse = [&](const std::string& what) {
        throw Error(ErrorKind::Device, "kernel '" + name + "' needs " + what, {}, "choose another device", {"device"});
    };
    const auto require = [&](bool needed, bool present, const std::string& what) {
        if (needed && !present)
            refuse(what + ", which '" + device.info.name + "' lacks");
    };
    const auto limit = [&](std::uint64_t needed, std::uint64_t most, const std::string& what) {
        if (needed > most)
            refuse(std::to_string(needed) + " " + what + ", '" + device.info.name + "' allows " + std::to_string(most));
    };
    require(interface.float64, device.info.float64, "64-bit floats");
    require(interface.int64, device.physical.getFeatures().shaderInt64, "64-bit integers");
    require(interface.int64Atomics, device.info.int64Atomics, "64-bit integer atomics");
    const auto [x, y, z] = interface.localSize;
    limit(std::uint64_t(x) * y * z, device.limits.maxComputeWorkGroupInvocations, "invocations in a workgroup");
    limit(interface.pushBytes, device.limits.maxPushConstantsSize, "bytes of push constants");
    // lavapipe does not check: with more than it allows, buffers take each other's place.
    const auto count = [&](vk::DescriptorType type) {
        return std::count_if(interface.bindings.begin(), interface.bindings.end(), [&](const auto& b) { return descriptorType(b.resource) == type; });
    };
    limit(std::uint64_t(count(vk::DescriptorType::eStorageBuffer)), device.limits.maxPerStageDescriptorStorageBuffers, "storage buffers");
    limit(std::uint64_t(count(vk::DescriptorType::eUniformTexelBuffer)), device.limits.maxPerStageDescriptorSampledImages, "texel buffers");
    limit(std::uint64_t(count(vk::DescriptorType::eStorageTexelBuffer)), device.limits.maxPerStageDescriptorStorageImages, "storage texel buffers");
}

vk::raii::DescriptorSetLayout createSetLayout(const vk::raii::Device& device, const KernelInterface& interface) {
    std::vector<vk::DescriptorSetLayoutBinding> bindings;
    for (const auto& declared : interface.bindings)
        bindings.emplace_back(declared.number, descriptorType(declared.resource), 1, vk::ShaderStageFlagBits::eCompute);
    return device.createDescriptorSetLayout({{}, bindings});
}

void createPipeline(Device::Impl& owner, Kernel::Impl& kernel) {
    const ScopedTime time(kernel.createSeconds);
    translating("compiling kernel '" + kernel.name + "'", [&] {
        const vk::raii::ShaderModule module(owner.device, {{}, kernel.spirv.size() * sizeof(std::uint32_t), kernel.spirv.data()});
        kernel.setLayout = createSetLayout(owner.device, kernel.interface);
        const vk::PushConstantRange push(vk::ShaderStageFlagBits::eCompute, 0, (kernel.interface.pushBytes + 3) / 4 * 4);
        vk::PipelineLayoutCreateInfo layout({}, *kernel.setLayout);
        if (push.size)
            layout.setPushConstantRanges(push);
        kernel.pipelineLayout = owner.device.createPipelineLayout(layout);
        kernel.pipeline = owner.device.createComputePipeline(
            nullptr, {{}, {{}, vk::ShaderStageFlagBits::eCompute, *module, "main"}, *kernel.pipelineLayout});
        owner.setName(kernel.pipeline, kernel.name);
    });
    owner.instance->throwValidationMessages();
}

// From any thread. Two that ask for the same kernel at once may each make one.
std::shared_ptr<Kernel::Impl> makeKernel(Device::Impl& owner, std::string_view name, std::span<const std::uint32_t> constants) {
    const KernelStore::Key key(std::string(name), std::vector<std::uint32_t>(constants.begin(), constants.end()));
    if (std::shared_ptr<Kernel::Impl> known = owner.kernels.find(key))
        return known;
    const EmbeddedKernel& embedded = findKernel(name);
    const KernelModule& module = embedded.variant(owner.variant);
    auto made = std::make_shared<Kernel::Impl>();
    made->device = &owner;
    made->name = embedded.name;
    made->interface = reflect(module.words, constants);
    requireCapabilities(owner, made->name, made->interface);
    made->spirv = owner.kernelCache.specialised(module, constants);
    if (std::shared_ptr<Kernel::Impl> known = owner.kernels.findSame(key, *made))
        return known;
    createPipeline(owner, *made);
    owner.kernels.add(key, made);
    return made;
}

} // namespace

vk::DescriptorType descriptorType(KernelInterface::Resource resource) {
    using Resource = KernelInterface::Resource;
    switch (resource) {
    case Resource::Storage: break;
    case Resource::Uniform: return vk::DescriptorType::eUniformBuffer;
    case Resource::TexelFloat:
    case Resource::TexelUint: return vk::DescriptorType::eUniformTexelBuffer;
    case Resource::StorageTexelFloat:
    case Resource::StorageTexelUint: return vk::DescriptorType::eStorageTexelBuffer;
    }
    return vk::DescriptorType::eStorageBuffer;
}

std::shared_ptr<Kernel::Impl> KernelStore::find(const Key& key) {
    const std::lock_guard lock(mutex_);
    const auto found = known_.find(key);
    return found == known_.end() ? nullptr : found->second.lock();
}

std::shared_ptr<Kernel::Impl> KernelStore::findSame(const Key& key, const Kernel::Impl& kernel) {
    const std::lock_guard lock(mutex_);
    for (const auto& [other, weak] : known_)
        if (other.first == key.first)
            if (std::shared_ptr<Kernel::Impl> candidate = weak.lock(); candidate && candidate->spirv == kernel.spirv) {
                known_[key] = candidate;
                return candidate;
            }
    return nullptr;
}

void KernelStore::add(const Key& key, const std::shared_ptr<Kernel::Impl>& kernel) {
    const std::lock_guard lock(mutex_);
    std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
    known_[key] = kernel;
    if (keeps_)
        kept_.push_back(kernel);
}

void KernelStore::keep() {
    const std::lock_guard lock(mutex_);
    keeps_ = true;
}

Kernel::Kernel(Device& device, std::string_view name, std::span<const std::uint32_t> constants) {
    const Stopwatch watch;
    impl_ = makeKernel(device.impl(), name, constants);
    device.impl().compileSeconds += watch.seconds();
}

std::vector<Kernel> makeKernels(Device& device, std::span<const KernelRequest> requests, Wanted wanted) {
    const Stopwatch watch;
    std::vector<Kernel> kernels(requests.size());
    std::vector<std::size_t> order(requests.size()); // the largest first: none of them shall be the last to begin
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) { return findKernel(requests[i].name).variant(device.variant()).words.size(); });
    parallelFor(requests.size(), 1, [&](std::size_t i, std::size_t) {
        const KernelRequest& request = requests[order[i]];
        const Processors::Place place(device.impl().processors, wanted == Wanted::Later);
        kernels[order[i]].impl_ = makeKernel(device.impl(), request.name, request.constants);
    });
    device.impl().compileSeconds += watch.seconds();
    return kernels;
}

Kernel Kernel::copyFor(Device& device) const {
    Kernel copy;
    copy.impl_ = std::make_shared<Impl>();
    copy.impl_->device = &device.impl();
    copy.impl_->name = impl_->name;
    copy.impl_->interface = impl_->interface;
    copy.impl_->spirv = impl_->spirv;
    createPipeline(device.impl(), *copy.impl_);
    return copy;
}

Kernel::Kernel() noexcept = default;
Kernel::~Kernel() = default;
Kernel::Kernel(Kernel&&) noexcept = default;
Kernel& Kernel::operator=(Kernel&&) noexcept = default;

const std::string& Kernel::name() const { return impl_->name; }
std::uint32_t Kernel::localSize() const {
    const auto [x, y, z] = impl_->interface.localSize;
    return x * y * z;
}

} // namespace cmpg

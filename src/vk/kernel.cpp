// One compute pipeline, laid out by what its SPIR-V declares.
#include "vk/device.h"

#include "vk/impl.h"
#include "vk/spirv.h"

#include <algorithm>

namespace cmpg {

namespace {

void requireCapabilities(const Device::Impl& device, const std::string& name, const KernelInterface& interface) {
    const auto refuse = [&](const std::string& what) {
        throw Error(ExitCode::Device, "kernel '" + name + "' needs " + what, {}, "choose another device with --device");
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
    for (const auto& [number, resource] : interface.bindings)
        bindings.emplace_back(number, descriptorType(resource), 1, vk::ShaderStageFlagBits::eCompute);
    return device.createDescriptorSetLayout({{}, bindings});
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

Kernel::Kernel(Device& device, std::string_view name, std::span<const std::uint32_t> constants) {
    Device::Impl& owner = device.impl();
    const std::pair<std::string, std::vector<std::uint32_t>> key(std::string(name), std::vector<std::uint32_t>(constants.begin(), constants.end()));
    if (const auto kept = owner.keptKernels.find(key); kept != owner.keptKernels.end()) {
        impl_ = kept->second;
        return;
    }
    impl_ = std::make_shared<Impl>();
    const ScopedTime time(owner.compileSeconds);
    const EmbeddedKernel& embedded = findKernel(name);
    const std::span<const std::uint32_t> spirv = embedded.variant(owner.variant);
    impl_->device = &owner;
    impl_->name = embedded.name;
    impl_->interface = reflect(spirv, constants);
    requireCapabilities(owner, impl_->name, impl_->interface);

    std::vector<vk::SpecializationMapEntry> entries;
    for (const std::uint32_t id : impl_->interface.specIds)
        if (id < constants.size())
            entries.emplace_back(id, id * 4, 4);
    translating("compiling kernel '" + impl_->name + "'", [&] {
        const vk::SpecializationInfo specialization(std::uint32_t(entries.size()), entries.data(), constants.size_bytes(),
                                                    constants.data());
        const vk::raii::ShaderModule module(owner.device, {{}, spirv.size_bytes(), spirv.data()});
        impl_->setLayout = createSetLayout(owner.device, impl_->interface);
        const vk::PushConstantRange push(vk::ShaderStageFlagBits::eCompute, 0, (impl_->interface.pushBytes + 3) / 4 * 4);
        vk::PipelineLayoutCreateInfo layout({}, *impl_->setLayout);
        if (push.size)
            layout.setPushConstantRanges(push);
        impl_->pipelineLayout = owner.device.createPipelineLayout(layout);
        impl_->pipeline = owner.device.createComputePipeline(
            nullptr, {{}, {{}, vk::ShaderStageFlagBits::eCompute, *module, "main", &specialization}, *impl_->pipelineLayout});
        owner.setName(impl_->pipeline, impl_->name);
    });
    owner.instance->throwValidationMessages();
    if (owner.keepsKernels)
        owner.keptKernels[key] = impl_;
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

// SPIR-V reflection and the table of kernels. Expected values are read off the GLSL of tests/shaders.
#include "vk/device.h"
#include "vk/spirv.h"
#include "vk/spirv_reflection.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace cmpg {
namespace {

using Resource = KernelInterface::Resource;

std::span<const std::uint32_t> spirv(std::string_view name) { return findKernel(name).full.words; }

TEST(Reflection, PushConstantsAndResources) {
    const KernelInterface interface = reflect(spirv("push_layout"));
    // Scalar layout: mat3 36, vec3 12, uint[3] 12, to 8 bytes 64, uint64 8, float 4.
    EXPECT_EQ(interface.pushBytes, 76u);
    EXPECT_EQ(interface.localSize, (std::array<std::uint32_t, 3>{4, 2, 3}));
    EXPECT_TRUE(interface.int64);
    EXPECT_FALSE(interface.int64Atomics);
    EXPECT_FALSE(interface.float64);
    EXPECT_TRUE(interface.specIds.empty());
    ASSERT_EQ(interface.bindings.size(), 3u);
    EXPECT_EQ(interface.bindings[0].number, 3u);
    EXPECT_EQ(interface.bindings[0].resource, Resource::TexelUint);
    EXPECT_EQ(interface.bindings[1].number, 11u);
    EXPECT_EQ(interface.bindings[1].resource, Resource::TexelFloat);
    EXPECT_EQ(interface.bindings[2].number, 60u);
    EXPECT_EQ(interface.bindings[2].resource, Resource::Storage);
}

// Of storage texel buffers alone, which declare it.
TEST(Reflection, TexelsOfOneNumber) {
    std::size_t one = 0, four = 0;
    for (const auto& b : reflect(findKernel("shade_escaped").cpu.words).bindings)
        if (b.resource == Resource::StorageTexelFloat)
            ++(b.oneNumber ? one : four);
    EXPECT_GT(one, 0u); // the environment's distribution
    EXPECT_GT(four, 0u);
    for (const auto& b : reflect(spirv("shade_escaped")).bindings)
        EXPECT_FALSE(b.oneNumber);
}

TEST(Reflection, SpecializedLocalSize) {
    EXPECT_EQ(reflect(spirv("specialized")).localSize[0], 32u);
    const std::array<std::uint32_t, 1> constants{128};
    const KernelInterface interface = reflect(spirv("specialized"), constants);
    EXPECT_EQ(interface.localSize, (std::array<std::uint32_t, 3>{128, 1, 1}));
    EXPECT_EQ(interface.specIds, (std::vector<std::uint32_t>{0, 1, 2, 4}));
    EXPECT_EQ(interface.pushBytes, 0u);
}

TEST(Reflection, OneBindingDeclaredTwice) {
    const KernelInterface interface = reflect(spirv("aliased"));
    ASSERT_EQ(interface.bindings.size(), 1u);
    EXPECT_EQ(interface.bindings[0].number, 2u);
}

TEST(Reflection, VariantsDiffer) {
    const KernelInterface full = reflect(spirv("sum_fixed")), portable = reflect(findKernel("sum_fixed").portable.words);
    EXPECT_TRUE(full.int64Atomics);
    EXPECT_FALSE(portable.int64Atomics || portable.int64);
}

TEST(Reflection, RefusesWhatIsNoSpirv) {
    const auto words = spirv("push_layout");
    EXPECT_THROW(reflect({}), std::invalid_argument);
    EXPECT_THROW(reflect(words.subspan(1)), std::invalid_argument);
    // Cut anywhere, the module must be refused or read, never overrun (checked by the sanitizer build).
    for (std::size_t length = 0; length < words.size(); ++length) {
        const std::vector<std::uint32_t> cut(words.begin(), words.begin() + std::ptrdiff_t(length));
        try {
            reflect(cut);
        } catch (const std::invalid_argument&) {
        }
    }
}

// Kernels of ours are portable by construction: every one declares what src/vk can bind, in all variants.
TEST(Reflection, EveryKernelOfTheLibrary) {
    const auto storageBuffers = [](const KernelInterface& kernel) {
        return std::uint32_t(std::count_if(kernel.bindings.begin(), kernel.bindings.end(), [](const auto& b) { return b.resource == Resource::Storage; }));
    };
    std::uint32_t most = 0, mostPortable = 0; // storage buffers, what is asked of devices
    for (const EmbeddedKernel& kernel : embeddedKernels()) {
        SCOPED_TRACE(kernel.name);
        const KernelInterface portable = reflect(kernel.portable.words);
        EXPECT_LE(portable.pushBytes, 128u);
        EXPECT_FALSE(portable.int64 || portable.int64Atomics || portable.float64);
        for (const auto& binding : portable.bindings)
            EXPECT_TRUE(binding.resource == Resource::Storage || binding.resource == Resource::Uniform) << "binding " << binding.number;
        const KernelInterface full = reflect(kernel.full.words);
        EXPECT_LE(full.pushBytes, 128u);
        EXPECT_FALSE(full.float64);
        const auto texelBuffers = [](const KernelInterface& k, Resource kind, Resource other) {
            return std::count_if(k.bindings.begin(), k.bindings.end(), [&](const auto& b) { return b.resource == kind || b.resource == other; });
        };
        EXPECT_LE(texelBuffers(full, Resource::TexelFloat, Resource::TexelUint), 16); // sampled images a stage: what Vulkan guarantees
        const KernelInterface cpu = reflect(kernel.cpu.words);
        EXPECT_LE(texelBuffers(cpu, Resource::StorageTexelFloat, Resource::StorageTexelUint), kStorageTexelBuffers);
        EXPECT_EQ(texelBuffers(cpu, Resource::TexelFloat, Resource::TexelUint), 0);
        EXPECT_LE(storageBuffers(cpu), kStorageBuffers);
        most = std::max(most, storageBuffers(full));
        mostPortable = std::max(mostPortable, storageBuffers(portable));
    }
    EXPECT_EQ(most, kStorageBuffers);
    EXPECT_EQ(mostPortable, kStorageBuffersPortable);
}

} // namespace
} // namespace cmpg

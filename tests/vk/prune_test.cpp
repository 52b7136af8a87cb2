// What constants leave of a kernel: valid SPIR-V, smaller, and with the same results.
#include "vk/device.h"
#include "vk/devices.h"
#include "vk/prune.h"
#include "vk/specialize.h"
#include "vk/spirv.h"
#include "vk/spirv_reflection.h"

#include <bit>
#include <gtest/gtest.h>
#include <random>
#include <spirv-tools/libspirv.hpp>

namespace cmpg {
namespace {

using Words = std::vector<std::uint32_t>;

std::string invalidity(const Words& words) { // empty: the validator has nothing to say
    std::string messages;
    spvtools::SpirvTools tools(SPV_ENV_VULKAN_1_3);
    tools.SetMessageConsumer([&](spv_message_level_t, const char*, const spv_position_t&, const char* text) { messages += std::string(text) + '\n'; });
    spvtools::ValidatorOptions options;
    options.SetScalarBlockLayout(true);
    if (!tools.Validate(words.data(), words.size(), options) && messages.empty())
        messages = "invalid";
    return messages;
}

// All constants zero, all one, and any of small numbers.
std::vector<Words> someConstants(std::span<const std::uint32_t> module) {
    const std::vector<std::uint32_t> ids = reflect(module).specIds;
    const std::size_t count = ids.empty() ? 0 : ids.back() + 1;
    std::vector<Words> result{Words(count, 0), Words(count, 1), Words(count)};
    std::mt19937 random(5);
    for (std::uint32_t& c : result.back())
        c = random() % 4;
    return result;
}

TEST(Prune, EveryKernelStaysValid) {
    for (const EmbeddedKernel& kernel : embeddedKernels())
        for (const KernelModule* module : {&kernel.cpu, &kernel.portable})
            for (Words constants : someConstants(module->words)) {
                SCOPED_TRACE(kernel.name);
                if (!constants.empty())
                    constants[0] = std::max(constants[0], 1u); // of some it is the workgroup's size
                const Words pruned = prune(module->words, constants);
                EXPECT_EQ(invalidity(pruned), "");
                EXPECT_TRUE(reflect(pruned).specIds.empty());
                EXPECT_EQ(invalidity(specialize(module->words, constants)), "");
            }
}

TEST(Prune, LeavesLittleOfWhatIsSwitchedOff) {
    const std::span<const std::uint32_t> module = findKernel("shade_vertex").cpu.words;
    const Words nothing(reflect(module).specIds.back() + 1, 0);
    EXPECT_LT(prune(module, nothing).size(), module.size() / 2);
}

// As shaders/switched.comp has it.
std::uint32_t met(std::uint32_t n, bool first, bool second, std::uint32_t bits, float scale) {
    const auto grown = [&](std::uint32_t m) { return std::uint32_t(float(m) * scale + 1.f); };
    const std::uint32_t shifted = bits >> 1 & 3u;
    std::uint32_t result = (first && n > 3 ? 1 : 0) + (second || n == 2 ? 2 : 0) + (first && second && n % 2 == 0 ? grown(n) << 8 : 0);
    result += (shifted == 3 ? n > 5 : first) ? 4 : 0;
    result += 16 * (second ? std::min(shifted, n) : shifted);
    return result + (!first && !second ? grown(n + 1) << 8 : 0);
}

TEST(Prune, ResultsAreThoseOfTheConstants) {
    constexpr std::uint32_t kCount = 10;
    Device& device = test::device();
    Words numbers(kCount);
    for (std::uint32_t i = 0; i < kCount; ++i)
        numbers[i] = i;
    Buffer in(device, "numbers", sizeof(std::uint32_t) * kCount, MemoryKind::Transient);
    const Buffer out(device, "result", sizeof(std::uint32_t) * kCount, MemoryKind::Transient);
    in.uploadAll(numbers);
    for (const std::uint32_t flags : {0u, 1u, 2u, 3u})
        for (const std::uint32_t bits : {0u, 2u, 6u, 13u})
            for (const float scale : {0.f, 1.5f}) {
                const std::array constants{flags & 1u, flags >> 1, bits, std::bit_cast<std::uint32_t>(scale)};
                const Kernel kernel(device, "switched", constants);
                Commands commands(device);
                commands.dispatch(kernel, Bindings().set(0, in).set(1, out), kCount, kCount);
                commands.submitAndWait();
                const Words result = out.downloadAll<std::uint32_t>(kCount);
                for (std::uint32_t i = 0; i < kCount; ++i)
                    EXPECT_EQ(result[i], met(i, flags & 1u, flags >> 1, bits, scale)) << i << ", flags " << flags << ", bits " << bits << ", scale " << scale;
            }
}

TEST(Prune, RefusesWhatIsNoSpirv) {
    const std::span<const std::uint32_t> words = findKernel("switched").full.words;
    EXPECT_THROW(prune({}, {}), std::invalid_argument);
    EXPECT_THROW(prune(words.subspan(1), {}), std::invalid_argument);
    // Cut or changed anywhere, it is refused or read, never overrun (checked by the sanitizer build).
    for (std::size_t at = 0; at < words.size(); ++at) {
        Words changed(words.begin(), words.end());
        changed[at] ^= 1u << at % 32;
        for (const std::span<const std::uint32_t> module : {words.first(at), std::span<const std::uint32_t>(changed)})
            try {
                prune(module, std::array{1u, 1u});
            } catch (const std::invalid_argument&) {
            }
    }
}

} // namespace
} // namespace cmpg

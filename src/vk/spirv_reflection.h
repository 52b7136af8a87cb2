// What a compute kernel's SPIR-V says about its own interface.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace cmpg {

struct KernelInterface {
    enum class Resource { Storage, Uniform, TexelFloat, TexelUint, StorageTexelFloat, StorageTexelUint };
    struct Binding {
        std::uint32_t number;
        Resource resource;
        bool oneNumber = false; // texels of one number each, as a storage texel buffer declares them; of others that is not known
        auto operator<=>(const Binding&) const = default;
    };
    std::vector<Binding> bindings; // by number
    std::uint32_t pushBytes = 0;   // end of the last member of the push-constant block
    std::array<std::uint32_t, 3> localSize{1, 1, 1};
    std::vector<std::uint32_t> specIds; // ids of the specialization constants, ascending
    bool float64 = false, int64 = false, int64Atomics = false; // capabilities that devices may lack
};

// `constants[i]` replaces specialization constant i where the local size depends on one.
// Throws std::invalid_argument when the words are no SPIR-V or use a kind of resource that src/vk does not bind.
KernelInterface reflect(std::span<const std::uint32_t> words, std::span<const std::uint32_t> constants = {});

// Whether the words have a SPIR-V header, and instructions that end where they do.
bool isWhole(std::span<const std::uint32_t> words);

} // namespace cmpg

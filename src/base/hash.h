// A hash of bytes, the same on all machines: FNV-1a in 64 bits. It finds accidents, not attacks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace cmpg {

inline std::uint64_t hashOf(std::span<const std::byte> bytes) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const std::byte byte : bytes)
        hash = (hash ^ std::uint64_t(byte)) * 0x100000001b3u;
    return hash;
}

} // namespace cmpg

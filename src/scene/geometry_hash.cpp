// A hash that tells one scene's geometry from another's.
#include "scene/scene.h"

#include <bit>

namespace cmpg {

std::uint64_t geometryHash(const Scene& scene) {
    std::uint64_t hash = 0xcbf29ce484222325; // FNV-1a by words
    const auto add = [&](std::uint32_t word) { hash = (hash ^ word) * 0x100000001b3; };
    for (const Triangle& t : scene.geometry.triangles)
        for (const std::uint32_t v : t.vertices)
            for (int c = 0; c < 3; ++c)
                add(std::bit_cast<std::uint32_t>(scene.geometry.positions[v][c]));
    return hash;
}

} // namespace cmpg

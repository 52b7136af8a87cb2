// Masses to fractions, children to a word.
#include "guiding/field/quadtree_texels.h"

#include "shared/guide.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

std::uint32_t fraction(double part, double rest) {
    constexpr double one = gpu::kQuadFractionOne;
    if (!(part + rest > 0))
        return gpu::kQuadFractionOne / 2; // nobody comes here
    const double least = part > 0 ? 1 : 0, most = rest > 0 ? one - 1 : one;
    return std::uint32_t(std::clamp(std::round(one * (part / (part + rest))), least, most));
}

std::uint32_t fractions(const QuadNode& node, double GuideMass::*part) {
    const auto mass = [&](std::size_t quadrant) { return node.mass[quadrant].*part; };
    return fraction(mass(0) + mass(2), mass(1) + mass(3)) | fraction(mass(0), mass(2)) << gpu::kQuadFractionBits |
           fraction(mass(1), mass(3)) << 2 * gpu::kQuadFractionBits;
}

} // namespace

glm::uvec4 quadtreeTexel(const QuadNode& node, std::uint32_t first) {
    std::uint32_t present = 0, eldest = 0;
    for (std::uint32_t quadrant = 4; quadrant-- > 0;)
        if (node.child[quadrant]) {
            present |= 1u << quadrant;
            eldest = first + node.child[quadrant];
        }
    return {fractions(node, &GuideMass::primal), fractions(node, &GuideMass::plus), fractions(node, &GuideMass::minus),
            eldest << gpu::kQuadChildBits | present};
}

} // namespace cmpg

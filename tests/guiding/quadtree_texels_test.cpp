// Quadtree nodes as kernels read them, and the order that this needs.
#include "guiding/field/quadtree_texels.h"

#include "guiding/field/quadtree.h"
#include "shared/guide.h"

#include <gtest/gtest.h>

namespace cmpg {
namespace {

std::uint32_t packed(std::uint32_t left, std::uint32_t belowLeft, std::uint32_t belowRight) {
    return left | belowLeft << gpu::kQuadFractionBits | belowRight << 2 * gpu::kQuadFractionBits;
}

TEST(QuadtreeTexels, HoldFractions) {
    constexpr std::uint32_t one = gpu::kQuadFractionOne, half = one / 2;
    QuadNode node;
    node.mass = {GuideMass{1, 0, 0}, GuideMass{1, 0, 1e-9}, GuideMass{2, 0, 1}, GuideMass{0, 0, 0}};
    const glm::uvec4 texel = quadtreeTexel(node, 7);
    EXPECT_EQ(texel.x, packed(std::uint32_t(std::lround(0.75 * one)), std::uint32_t(std::lround(one / 3.0)), one)); // all of the right lies below
    EXPECT_EQ(texel.y, packed(half, half, half));                                                             // nothing anywhere
    EXPECT_EQ(texel.z, packed(one - 1, 0, one)); // next to nothing on the right is still drawn, nothing below on the left is not
    EXPECT_EQ(texel.w, 0u);
    // Sums near the ends of what a double holds.
    node.mass = {GuideMass{1e-320, 1e300, 0}, GuideMass{1e-320, 1e300, 0}, GuideMass{0, 0, 0}, GuideMass{0, 0, 0}};
    EXPECT_EQ(quadtreeTexel(node, 0).x & one, half + 1); // rounds 511.5 up
    EXPECT_EQ(quadtreeTexel(node, 0).y & one, half + 1);
}

TEST(QuadtreeTexels, HoldChildren) {
    for (std::uint32_t present = 0; present < 16; ++present) {
        QuadNode node;
        std::uint32_t next = 5;
        for (std::uint32_t q = 0; q < 4; ++q)
            if (present >> q & 1)
                node.child[q] = next++;
        EXPECT_EQ(quadtreeTexel(node, 100).w, present ? 105u << gpu::kQuadChildBits | present : 0u);
    }
}

TEST(Quadtree, ChildrenLieSideBySide) {
    std::vector<QuadNode> nodes(5);
    nodes[0].child = {1, 2, 0, 3};
    nodes[1].child = {0, 4, 0, 0};
    EXPECT_EQ(validateQuadtree(nodes, 10), "");
    nodes[0].child = {2, 1, 0, 3};
    EXPECT_NE(validateQuadtree(nodes, 10).find("side by side"), std::string::npos);
    nodes[0].child = {1, 2, 0, 4};
    nodes[1].child = {0, 3, 0, 0};
    EXPECT_NE(validateQuadtree(nodes, 10).find("side by side"), std::string::npos);
}

} // namespace
} // namespace cmpg

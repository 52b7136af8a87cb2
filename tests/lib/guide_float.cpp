// The guide's look-ups, weights and walks in the float build: densities integrate to one, draws follow them.
#include "shader_float.h"

#include "guide_table.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <random>

namespace cmpg::test {
namespace {

using Library = shader_float::ShaderLibrary;
using namespace gpu;

constexpr float kWeights[] = {0, 1e-30, 1e-6, 0.3, 1, 2e5, 1e30};
constexpr std::uint32_t kKinds[] = {kGuidePrimal, kGuideDifferential, kGuideUniform, kGuideConditional};
const double kSphere = 4 * std::acos(-1.0L);

Library libraryOf(const GuideTable& table) {
    Library library;
    library.guideSpatial = table.spatial;
    library.guideNodes = table.nodes;
    return library;
}

struct Leaf {
    std::uint32_t quadrant;
    glm::dvec2 corner;
    double edge;
};

void addLeaves(const GuideTable& table, std::uint32_t node, glm::dvec2 corner, double edge, std::vector<Leaf>& leaves) {
    for (std::uint32_t q = 0; q < 4; ++q) {
        const glm::dvec2 at = corner + 0.5 * edge * glm::dvec2(q & 1, q >> 1);
        if (const std::uint32_t child = table.children[4 * node + q]) addLeaves(table, child, at, 0.5 * edge, leaves);
        else leaves.push_back({4 * node + q, at, 0.5 * edge});
    }
}

std::vector<Leaf> leavesOf(const GuideTable& table, std::uint32_t cell) {
    std::vector<Leaf> leaves;
    addLeaves(table, table.cells[cell].root, {0, 0}, 1, leaves);
    return leaves;
}

float uniform(std::mt19937& random) { return float(random() >> 8) * 0x1p-24f; }

// Densities times solid angle over the leaves; 0 where the cell has nothing to draw from. The leaves' middles stand for all of them.
double integral(Library& library, const GuideTable& table, std::uint32_t cell, const glm::vec3& weights) {
    EXPECT_TRUE(std::isfinite(dot(weights, table.cells[cell].total)));
    const glm::vec3 parts = library.guideParts(weights, table.cells[cell].total);
    if (parts == glm::vec3(0)) return 0;
    double sum = 0;
    for (const Leaf& leaf : leavesOf(table, cell)) {
        const double density = double(library.guideDensity(table.cells[cell].root, parts, glm::vec2(leaf.corner + 0.5 * leaf.edge)));
        EXPECT_GE(density, 0);
        sum += density * leaf.edge * leaf.edge * kSphere;
    }
    return sum;
}

// Every kind, sign and size of weights on random quadtrees, also with masses at the ends of what is published.
TEST(Guide, DensityIntegratesToOne) {
    int something = 0, nothing = 0;
    for (std::uint32_t seed = 0; seed < 96; ++seed) {
        const GuideTable table = randomTable(seed, seed % 3 == 0 ? 30 : seed % 3 == 1 ? 10 : 3, seed / 3 % 8);
        Library library = libraryOf(table);
        for (const std::uint32_t kind : kKinds)
            for (const int sign : {0, 1, -1})
                for (const float light : kWeights)
                    for (const float derivative : kWeights) {
                        const glm::vec3 weights = library.guideWeights(kind, table.cells[0].total, light, derivative, sign);
                        const double sum = integral(library, table, 0, weights);
                        (sum == 0 ? nothing : something) += 1;
                        if (sum == 0) continue;
                        ASSERT_NEAR(sum, 1, 1e-4) << "seed " << seed << " kind " << kind << " sign " << sign << " weights " << light << ' ' << derivative;
                    }
    }
    EXPECT_GT(something, 10000);
    EXPECT_GT(nothing, 100);
}

TEST(Guide, DensityIntegratesToOneAfterAHundredUpdates) {
    std::mt19937 random(3);
    for (const std::uint32_t updates : {1u, 100u}) {
        const GuideTable table = grownTable(updates, 1);
        Library library = libraryOf(table);
        ASSERT_GT(table.cells.size(), 5u);
        for (std::uint32_t cell = 0; cell < table.cells.size(); ++cell)
            for (const std::uint32_t kind : kKinds) {
                const glm::vec3 total = table.cells[cell].total;
                const glm::vec3 weights = library.guideWeights(kind, total, std::exp(8 * uniform(random) - 4), 1, int(random() % 3) - 1);
                const float light = kind == kGuideDifferential ? 0 : total.x, derivative = kind == kGuidePrimal ? 0 : total.y + total.z;
                ASSERT_NEAR(integral(library, table, cell, weights), light + derivative > 0, 1e-4) << "cell " << cell << " kind " << kind;
            }
    }
}

// The whole sphere by a regular grid of directions: neither knows of leaves.
TEST(Guide, DensityOverDirectionsIntegratesToOne) {
    const GuideTable table = grownTable(3, 2);
    Library library = libraryOf(table);
    const glm::vec3 weights = library.guideWeights(kGuideConditional, table.cells[0].total, 0.7, 1.3, 0);
    const glm::vec3 parts = library.guideParts(weights, table.cells[0].total);
    const int width = 2048, height = 2048; // twice as fine as the deepest quadtree
    double sum = 0;
    for (int j = 0; j < height; ++j)
        for (int i = 0; i < width; ++i) {
            const double z = (2 * j + 1) / double(height) - 1, phi = kSphere / 2 * (i + 0.5) / width, r = std::sqrt(1 - z * z);
            const glm::vec3 d(glm::dvec3(r * std::cos(phi), r * std::sin(phi), z));
            sum += double(library.guideDensity(table.cells[0].root, parts, library.squareFromDirection(d)));
        }
    EXPECT_NEAR(sum * kSphere / (width * height), 1, 1e-4);
}

// Nodes hold fractions of ten bits: what a leaf is drawn with is near its share of the mixture, and 0 only where that is. Over both axes of ten
// levels, each off by a unit at most, the leaves' probabilities cannot move by more than 20 units in all.
TEST(Guide, FractionsFollowTheMasses) {
    std::mt19937 random(9);
    int zeros = 0;
    for (std::uint32_t seed = 0; seed < 64; ++seed) {
        const GuideTable table = seed % 2 ? randomTable(seed, 3, seed / 2 % 7) : grownTable(1 + seed % 5, seed);
        Library library = libraryOf(table);
        const std::uint32_t cell = random() % std::uint32_t(table.cells.size());
        const glm::vec3 total = table.cells[cell].total;
        const glm::vec3 parts = library.guideParts(library.guideWeights(kKinds[seed / 2 % 4], total, uniform(random), uniform(random), int(seed % 3) - 1), total);
        glm::dvec3 whole(0);
        for (std::uint32_t q = 0; q < 4; ++q) whole += table.masses[4 * table.cells[cell].root + q];
        double moved = 0;
        for (const Leaf& leaf : leavesOf(table, cell)) {
            double share = 0;
            for (int part = 0; part < 3; ++part)
                if (whole[part] > 0) share += double(parts[part]) * table.masses[leaf.quadrant][part] / whole[part];
            const float density = library.guideDensity(table.cells[cell].root, parts, glm::vec2(leaf.corner + 0.5 * leaf.edge));
            ASSERT_EQ(density > 0, share > 0) << seed;
            moved += 0.5 * std::abs(double(density) * leaf.edge * leaf.edge * kSphere - share);
            zeros += share == 0;
        }
        EXPECT_LT(moved, 20.0 / kQuadFractionOne) << seed;
    }
    EXPECT_GT(zeros, 100);
}

// Draws fall into the leaves as often as the density says, and evenly within them. 64 tables, two tests each; a right sampler fails
// with probability 1 % (Bonferroni), and the seeds are fixed.
TEST(Guide, DrawsFollowTheDensity) {
    constexpr int kSamples = 100000, kTables = 64;
    int tested = 0;
    for (std::uint32_t seed = 0; seed < kTables; ++seed) {
        const GuideTable table = seed % 2 ? randomTable(seed, 3, seed / 2 % 7) : grownTable(1 + seed % 5, seed);
        Library library = libraryOf(table);
        std::mt19937 random(seed);
        const std::uint32_t cell = random() % std::uint32_t(table.cells.size());
        const glm::vec3 weights = library.guideWeights(kKinds[seed / 2 % 4], table.cells[cell].total, uniform(random), uniform(random), int(seed % 3) - 1);
        const glm::vec3 parts = library.guideParts(weights, table.cells[cell].total);
        if (parts == glm::vec3(0)) continue;
        ++tested;
        const std::vector<Leaf> leaves = leavesOf(table, cell);
        std::map<std::uint32_t, std::size_t> place;
        std::vector<double> expected, observed(leaves.size(), 0.0), within(16, 0.0);
        for (const Leaf& leaf : leaves) {
            place[leaf.quadrant] = expected.size();
            const float density = library.guideDensity(table.cells[cell].root, parts, glm::vec2(leaf.corner + 0.5 * leaf.edge));
            expected.push_back(double(density) * leaf.edge * leaf.edge * kSphere * kSamples);
        }
        for (int i = 0; i < kSamples; ++i) {
            const float x = uniform(random), y = uniform(random);
            const std::uint32_t part = library.guidePart(parts, uniform(random));
            const Library::GuideWalk walk = library.guideWalk(table.cells[cell].root, parts, true, part, {x, y});
            ASSERT_GT(walk.density, 0);
            ASSERT_TRUE(place.contains(walk.leaf));
            const std::size_t k = place[walk.leaf];
            ++observed[k];
            const glm::dvec2 inside = (glm::dvec2(walk.point) - leaves[k].corner) / leaves[k].edge;
            ASSERT_TRUE(inside.x >= 0 && inside.y >= 0 && inside.x <= 1 && inside.y <= 1);
            ++within[std::min<std::size_t>(3, std::size_t(4 * inside.x)) + 4 * std::min<std::size_t>(3, std::size_t(4 * inside.y))];
        }
        EXPECT_GT(significance(observed, expected), 0.01 / (2 * kTables)) << seed;
        EXPECT_GT(significance(within, std::vector<double>(16, kSamples / 16.0)), 0.01 / (2 * kTables)) << seed;
    }
    EXPECT_GT(tested, 50);
}

// One density, however it is asked for: drawing, following, alone, and by way of the direction. A point within rounding of a
// quadrant's border may count to either side.
TEST(Guide, WalksAgree) {
    std::mt19937 random(4);
    int borders = 0, points = 0;
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
        const GuideTable table = randomTable(seed, 3, 0);
        Library library = libraryOf(table);
        const std::uint32_t root = table.cells[0].root;
        const glm::vec3 weights = library.guideWeights(kKinds[seed % 4], table.cells[0].total, uniform(random), uniform(random), 0);
        const glm::vec3 parts = library.guideParts(weights, table.cells[0].total);
        for (int i = 0; i < 5000; ++i) {
            const float x = uniform(random), y = uniform(random);
            const Library::GuideWalk drawn = library.guideWalk(root, parts, true, library.guidePart(parts, uniform(random)), {x, y});
            const glm::vec2 again = library.squareFromDirection(library.directionFromSquare(drawn.point));
            const Library::GuideWalk followed = library.guideWalk(root, parts, false, 0, again);
            ASSERT_FLOAT_EQ(followed.density, library.guideDensity(root, parts, again));
            ++points;
            if (followed.leaf != drawn.leaf) {
                // 2e-7 of rounding on either side of a border; the finest are 2^-10 apart.
                const glm::vec2 fine = glm::fract(1024.0f * drawn.point + 0.5f);
                ASSERT_LT(std::min(std::abs(fine.x - 0.5), std::abs(fine.y - 0.5)), 1024 * 3e-7 + 1e-4);
                ++borders;
                continue;
            }
            ASSERT_FLOAT_EQ(followed.density, drawn.density);
        }
    }
    EXPECT_LT(borders, points / 200); // 2 axes x 1024 borders x 6e-7 at most
}

TEST(Guide, MapsDirectionsToTheSquareAndBack) {
    Library library;
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 200000; ++i) {
        const glm::dvec3 d = glm::normalize(glm::dvec3(normal(random), normal(random), (i % 2 ? 1e3 : 1.0) * normal(random)));
        const glm::vec2 s = library.squareFromDirection(glm::vec3(d));
        ASSERT_TRUE(s.x >= 0 && s.x < 1 && s.y >= 0 && s.y < 1);
        ASSERT_NEAR(double(s.y), 0.5 + 0.5 * d.z, 1e-7);
        // A step of 6e-8 of (1 + z) / 2 near a pole is one of its root in the direction.
        const double r = std::max<double>(std::hypot(d.x, d.y), 3e-4);
        ASSERT_LT(glm::length(glm::dvec3(library.directionFromSquare(s)) - d), 1e-6 + 3e-7 / r);
    }
    for (int i = 0; i < 200000; ++i) {
        const float x = uniform(random), y = i % 3 == 0 ? uniform(random) : i % 3 == 1 ? 1e-7f * (uniform(random) + 1e-3f) : 1 - 6e-8f * float(1 + random() % 4);
        const glm::vec3 d = library.directionFromSquare({x, y});
        ASSERT_NEAR(length(d), 1, 1e-6);
        const glm::vec2 s = library.squareFromDirection(d);
        ASSERT_NEAR(s.y, y, 2e-7);
        const double turn = std::abs(double(s.x) - x);
        ASSERT_LT(std::min(turn, 1 - turn), 2e-6);
    }
    // Poles, the seam, and the ends of the square.
    const float tiny = 1e-30;
    for (const glm::vec3& d : {glm::vec3(0, 0, 1), glm::vec3(0, 0, -1), glm::vec3(1, 0, 0), glm::vec3(1, -tiny, 0), glm::vec3(1, tiny, 0),
                               glm::vec3(-1, 0, 0), glm::vec3(-1, -tiny, 0), glm::vec3(1, -1e-8f, 0)}) {
        const glm::vec2 s = library.squareFromDirection(d);
        EXPECT_TRUE(s.x >= 0 && s.x < 1 && s.y >= 0 && s.y < 1) << d.x << ' ' << d.y << ' ' << d.z;
        EXPECT_LT(glm::length(library.directionFromSquare(s) - d), 1e-3); // at a pole the nearest point below 1 is 3.5e-4 away
    }
    for (const glm::vec2& s : {glm::vec2(0, 0), glm::vec2(0.5, 0), glm::vec2(0.99999994, 0.99999994), glm::vec2(0, 0.5)})
        EXPECT_NEAR(length(library.directionFromSquare(s)), 1, 1e-6);
}

TEST(Guide, FindsTheHostsCells) {
    std::mt19937 random(6);
    for (const std::uint32_t updates : {0u, 1u, 20u}) {
        const GuideTable table = grownTable(updates, 3);
        Library library = libraryOf(table);
        const glm::vec3 upper = table.lower + 1.0f / table.inverseExtent, extent = upper - table.lower;
        for (int i = 0; i < 100000; ++i) {
            glm::vec3 p;
            for (int axis = 0; axis < 3; ++axis)
                switch (random() % 8) {
                case 0: p[axis] = table.lower[axis]; break;
                case 1: p[axis] = upper[axis]; break;
                case 2: p[axis] = table.lower[axis] + extent[axis] * (3 * uniform(random) - 1); break; // mostly outside
                case 3: p[axis] = table.lower[axis] + extent[axis] * float(random() % 65) / 64; break; // between cells
                default: p[axis] = table.lower[axis] + extent[axis] * uniform(random);
                }
            ASSERT_EQ(library.guideCellAt((p - table.lower) * table.inverseExtent), table.cellAt(p)) << p.x << ' ' << p.y << ' ' << p.z;
        }
    }
}

TEST(Guide, EmptyCellsHaveNoScore) {
    const GuideTable table = grownTable(0, 1);
    Library library = libraryOf(table);
    for (const std::uint32_t kind : kKinds)
        for (const int sign : {0, 1, -1})
            for (const float light : kWeights)
                for (const float derivative : kWeights)
                    EXPECT_EQ(dot(library.guideWeights(kind, table.cells[7].total, light, derivative, sign), table.cells[7].total), 0);
    // Nothing of what a kind looks at, or a path that carries nothing.
    EXPECT_EQ(dot(library.guideWeights(kGuideDifferential, {1, 0, 0}, 1, 1, 0), glm::vec3(1, 0, 0)), 0);
    EXPECT_EQ(dot(library.guideWeights(kGuidePrimal, {0, 1, 2}, 1, 1, 0), glm::vec3(0, 1, 2)), 0);
    EXPECT_EQ(dot(library.guideWeights(kGuideConditional, {1, 2, 3}, 0, 0, 0), glm::vec3(1, 2, 3)), 0);
    // At a camera's vertex the path has met no parameter: what it will find of them decides alone.
    EXPECT_EQ(dot(library.guideWeights(kGuideConditional, {1, 0, 0}, 0, 1, 0), glm::vec3(1, 0, 0)), 0);
    EXPECT_EQ(library.guideWeights(kGuideConditional, {1, 2, 3}, 0, 1, 0), glm::vec3(0, 1, 1));
}

// P has a quarter of the conditional mixture at least, and is left alone where it has more or knows nothing.
TEST(Guide, KeepsAQuarterForLight) {
    Library library;
    std::mt19937 random(8);
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 total(std::exp(40 * uniform(random) - 20), std::exp(6 * uniform(random) - 3), std::exp(6 * uniform(random) - 3));
        for (const float light : kWeights)
            for (const float derivative : kWeights) {
                const glm::vec3 plain = library.guideWeights(kGuideConditional, total, light, derivative, int(random() % 3) - 1);
                const glm::vec3 defended = library.guideDefended(plain, total), parts = defended * total;
                EXPECT_EQ(glm::vec2(defended.y, defended.z), glm::vec2(plain.y, plain.z));
                const float all = parts.x + parts.y + parts.z;
                if (plain.x * total.x >= 0.2501f * all) {
                    EXPECT_EQ(defended, plain);
                } else if (all > 0) {
                    EXPECT_NEAR(parts.x / all, 0.25f, 1e-4f);
                }
                EXPECT_TRUE(std::isfinite(all));
            }
    }
    EXPECT_EQ(library.guideDefended({0, 1, 1}, {0, 2, 3}), glm::vec3(0, 1, 1));
    EXPECT_EQ(library.guideDefended({0, 0, 0}, {1, 2, 3}), glm::vec3(0));
}

// Positivization moves mass between D+ and D- and keeps the balance of light and derivatives.
TEST(Guide, SignsKeepTheBalance) {
    Library library;
    std::mt19937 random(7);
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 total(std::exp(6 * uniform(random) - 3), std::exp(6 * uniform(random) - 3), std::exp(6 * uniform(random) - 3));
        const float light = uniform(random), derivative = uniform(random);
        for (const std::uint32_t kind : kKinds)
            for (const int sign : {1, -1}) {
                const glm::vec3 parts = library.guideWeights(kind, total, light, derivative, sign) * total;
                const glm::vec3 plain = library.guideWeights(kind, total, light, derivative, 0) * total;
                EXPECT_NEAR(parts.x, plain.x, 1e-5 * (parts.x + 1e-30));
                EXPECT_NEAR(parts.y + parts.z, plain.y + plain.z, 1e-5 * (plain.y + plain.z));
                if (kind == kGuidePrimal) continue;
                EXPECT_NEAR((sign > 0 ? parts.y : parts.z) / (parts.y + parts.z), 0.95, 1e-5);
            }
        const glm::vec3 conditional = library.guideWeights(kGuideConditional, total, light, derivative, 0);
        EXPECT_NEAR(conditional.x * derivative, conditional.y * light, 1e-6);
        const glm::vec3 halves = library.guideWeights(kGuideUniform, total, light, derivative, 0) * total;
        EXPECT_NEAR(halves.x, halves.y + halves.z, 1e-5);
    }
}

} // namespace
} // namespace cmpg::test

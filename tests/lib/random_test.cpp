// Keyed random numbers: uniform, and unrelated between neighbouring keys.
#include "shader_double.h"

#include "statistics.h"

#include <gtest/gtest.h>
#include <random>

namespace cmpg::test {
namespace {

using Library = shader_double::ShaderLibrary;

Library::SampleKey makeKey(Library& library, std::uint32_t pixel, std::uint32_t sample) {
    return {library.streamKey(1, 0, 2, 3), pixel, sample, 0, 1};
}

// What a number belongs to.
enum Field { SeedLow, SeedHigh, Step, Pass, Pixel, Sample, Branch, Bounce, Set, kFields };

glm::uvec4 bitsOf(Library& library, const std::uint32_t (&v)[kFields]) {
    const Library::SampleKey key{library.streamKey(v[SeedLow], v[SeedHigh], v[Step], v[Pass]), v[Pixel], v[Sample], v[Branch], v[Bounce]};
    return glm::uvec4(library.independentSet(key, v[Set]) * 16777216.0);
}

// Flipping one bit of the key flips every bit of the result half of the time: within 6 sigma for all 288 * 72 pairs of bits,
// which a right generator misses with probability 4e-5.
TEST(Random, EveryKeyBitChangesEveryResultBit) {
    Library library;
    constexpr int kTrials = 4000;
    std::mt19937 random(1);
    for (int field = 0; field < kFields; ++field) {
        for (int bit = 0; bit < 32; ++bit) {
            int flips[72] = {};
            for (int t = 0; t < kTrials; ++t) {
                std::uint32_t v[kFields];
                for (std::uint32_t& x : v) x = random() >> (t % 32); // small numbers as well
                const glm::uvec4 before = bitsOf(library, v);
                v[field] ^= 1u << bit;
                const glm::uvec4 change = before ^ bitsOf(library, v);
                for (int b = 0; b < 72; ++b) flips[b] += change[b / 24] >> (b % 24) & 1;
            }
            for (int b = 0; b < 72; ++b) {
                ASSERT_NEAR(flips[b], kTrials / 2, 6 * 0.5 * std::sqrt(kTrials)) << "field " << field << " bit " << bit << " result bit " << b;
            }
        }
    }
}

// Pairs of numbers from neighbouring keys fill the unit square evenly: chi-square over 32 x 32 cells. 36 cases share a
// probability of 1 % for a wrong alarm.
TEST(Random, NeighboursAreIndependent) {
    Library library;
    library.kSobol = false;
    for (int field = Pixel; field < kFields; ++field) {
        for (int component = 0; component < 8; ++component) {
            std::vector<double> observed(1024, 0.0);
            constexpr int kPairs = 1 << 17;
            for (std::uint32_t i = 0; i < kPairs; ++i) {
                // A 512-pixel image with 256 samples, counted up in order.
                Library::SampleKey key = makeKey(library, i >> 8, i & 255);
                const glm::dvec4 a = library.sampleSet(key, 0);
                std::uint32_t set = 0;
                if (field == Pixel) ++key.pixel;
                if (field == Sample) ++key.sampleIndex;
                if (field == Branch) ++key.branch;
                if (field == Bounce) ++key.bounce;
                if (field == Set) ++set;
                const glm::dvec4 b = library.sampleSet(key, set);
                const int x = int(a[component / 2] * 32), y = int(b[(component / 2 + component % 2) % 4] * 32);
                observed[x * 32 + y] += 1;
            }
            EXPECT_GE(chiSquareSignificance(observed, std::vector<double>(1024, kPairs / 1024.0)), 0.01 / 40) << "field " << field << ' ' << component;
        }
    }
}

TEST(Random, StaysBelowOne) {
    Library library;
    EXPECT_EQ(library.unitInterval(glm::uvec4(0xffffffffu)), glm::dvec4(1 - 0x1p-24));
    EXPECT_EQ(library.unitInterval(glm::uvec4(0u)), glm::dvec4(0));
}

} // namespace
} // namespace cmpg::test

// How many samples the pictures of a run have.
#include "app/run_pictures.h"

#include <gtest/gtest.h>

namespace cmpg {
namespace {

std::vector<SeenView> viewsOf(std::size_t count) { return std::vector<SeenView>(count, SeenView{"", 100, 50}); }

TEST(RunPictures, HaveFourTimesTheSamplesOfAStep) {
    Options options;
    options.spp = 4;
    EXPECT_EQ(pictureSamples(options, viewsOf(1), 1e-6), 64u); // at least
    options.spp = 50;
    EXPECT_EQ(pictureSamples(options, viewsOf(4), 1e-6), 200u);
    EXPECT_EQ(pictureSamples(options, viewsOf(8), 1e-6), 100u);
    EXPECT_EQ(pictureSamples(options, viewsOf(1000), 1e-6), 8u);
    options.sppPictures = 3;
    EXPECT_EQ(pictureSamples(options, viewsOf(8), 1e-6), 3u);
}

TEST(RunPictures, TakeATenthOfATimeBudget) {
    Options options;
    options.spp = 16;
    options.timeBudget = 20.f;
    // Two pictures of 5000 pixels.
    EXPECT_EQ(pictureSamples(options, viewsOf(1), 1e-5), 20u);
    EXPECT_EQ(pictureSamples(options, viewsOf(1), 1e-6), 64u); // as without
    EXPECT_EQ(pictureSamples(options, viewsOf(1), 1e-3), 16u); // at least
    EXPECT_EQ(pictureSamples(options, viewsOf(1), 0), 64u);    // not known
    EXPECT_EQ(pictureSamples(options, viewsOf(32), 1e-3), 8u);
    const std::vector<SeenView> large(8, SeenView{"", 512, 256}), larger(8, SeenView{"", 512, 512});
    EXPECT_EQ(pictureSamples(options, large, 1e-3), 2u);
    EXPECT_EQ(pictureSamples(options, larger, 1e-3), 2u);
    EXPECT_EQ(pictureSamples(options, {large.data(), 1}, 1e-5), 2u);
    EXPECT_EQ(pictureSamples(options, {large.data(), 1}, 1e-6), 7u);
    options.sppPictures = 300;
    EXPECT_EQ(pictureSamples(options, viewsOf(1), 1e-3), 300u);
}

} // namespace
} // namespace cmpg

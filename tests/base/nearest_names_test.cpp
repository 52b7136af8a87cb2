#include "base/nearest_names.h"

#include <gtest/gtest.h>

namespace cmpg {
namespace {

TEST(NearestNames, DistanceCountsLetters) {
    EXPECT_EQ(editDistance("", ""), 0u);
    EXPECT_EQ(editDistance("", "abc"), 3u);
    EXPECT_EQ(editDistance("kitten", "sitting"), 3u); // the textbook's: k to s, e to i, g put in
    EXPECT_EQ(editDistance("sitting", "kitten"), 3u);
    EXPECT_EQ(editDistance("ab", "ba"), 2u);
}

TEST(NearestNames, TheNearestComeFirstAndOthersKeepTheirOrder) {
    const std::vector<std::string> names = {"wall.normal", "wall.emission", "lamp.emission", "wall.baseColor"};
    EXPECT_EQ(nearestNames(names, "wall.basecolor", 2), (std::vector<std::string>{"wall.baseColor", "wall.normal"}));
    EXPECT_EQ(nearestNames({"ab", "ac", "ad"}, "aa", 3), (std::vector<std::string>{"ab", "ac", "ad"}));
    EXPECT_TRUE(nearestNames({}, "a", 3).empty());
    EXPECT_TRUE(nearestNames(names, "a", 0).empty());
}

TEST(NearestNames, MeantIsOnlyWhatIsNear) {
    const std::vector<std::string> names = {"render", "gradient", "view"};
    EXPECT_EQ(likelyMeant(names, "rendr"), "render");
    EXPECT_EQ(likelyMeant(names, "veiw"), "");  // half of its letters
    EXPECT_EQ(likelyMeant(names, "vew"), "view");
    EXPECT_EQ(likelyMeant(names, "frobnicate"), "");
    EXPECT_EQ(likelyMeant({}, "render"), "");
}

} // namespace
} // namespace cmpg

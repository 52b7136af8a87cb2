// What is written beside pictures.
#include "viewer/picture_text.h"

#include <gtest/gtest.h>

namespace cmpg::viewer {
namespace {

// Scenes far from their origin are moved to it for the work, and tell the places of their files.
TEST(PictureText, PointsAreThoseOfTheFile) {
    LiveScene scene;
    scene.lower = glm::vec3(-2);
    scene.upper = glm::vec3(2);
    EXPECT_EQ(pointText(scene, {0.5f, -1.25f, 0}), "0.500  -1.250  0.000");
    scene.center = {500123.4375, 4649776.25, 12};
    EXPECT_EQ(pointText(scene, {0.5f, -1.25f, 0}), "500123.938  4649775.000  12.000");
    scene.lower = glm::vec3(-2000);
    EXPECT_EQ(pointText(scene, {0.5f, -1.25f, 0}), "500124  4649775  12");
    scene.lower = scene.upper; // a scene without extent
    scene.center = {};
    EXPECT_EQ(pointText(scene, {1, 2, 3}), "1.000000000  2.000000000  3.000000000");
}

} // namespace
} // namespace cmpg::viewer

// Moving cameras, and where directions of the guide's maps lead.
#include "viewer/camera_control.h"
#include "viewer/sphere_map.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>
#include <random>

namespace cmpg::viewer {
namespace {

Camera lookingAt(glm::vec3 eye, glm::vec3 point) {
    Camera camera;
    setPose(camera, glm::inverse(glm::lookAt(eye, point, glm::vec3(0, 1, 0))));
    return camera;
}

TEST(CameraControl, OrbitKeepsDistanceAndHorizon) {
    Camera camera = lookingAt({3, 2, 5}, {0.3f, 1, -1});
    const glm::vec3 pivot(0.3f, 1, -1);
    const float distance = glm::length(eyeOf(camera) - pivot);
    std::mt19937 random(2);
    std::uniform_real_distribution<float> angle(-0.3f, 0.3f);
    for (int i = 0; i < 500; ++i) {
        orbit(camera, pivot, angle(random), angle(random));
        ASSERT_NEAR(glm::length(eyeOf(camera) - pivot), distance, 2e-3f * distance);
        ASSERT_NEAR(glm::normalize(glm::vec3(poseOf(camera)[0])).y, 0, 2e-3f); // right stays level
        ASSERT_GT(glm::normalize(glm::vec3(poseOf(camera)[1])).y, 0);          // and up is up
    }
    EXPECT_LT(glm::length(glm::normalize(pivot - eyeOf(camera)) - forwardOf(camera)), 1e-2f); // still in the middle
}

TEST(CameraControl, TurnsTowardsTheDrag) {
    Camera camera = lookingAt({0, 0, 5}, {0, 0, 0});
    orbit(camera, {0, 0, 0}, 0.5f, 0);
    EXPECT_GT(eyeOf(camera).x, 1); // counterclockwise about +y
    camera = lookingAt({0, 0, 5}, {0, 0, 0});
    orbit(camera, {0, 0, 0}, 0, -0.5f);
    EXPECT_GT(eyeOf(camera).y, 1);
}

TEST(CameraControl, SlidesAlongItsAxes) {
    Camera camera = lookingAt({0, 1, 5}, {0, 1, 0});
    slide(camera, {2, 0.5f, 3});
    EXPECT_LT(glm::length(eyeOf(camera) - glm::vec3(2, 1.5f, 2)), 1e-5f);
}

TEST(CameraControl, ApproachesThePivot) {
    Camera camera = lookingAt({0, 0, 8}, {0, 0, 0});
    approach(camera, {0, 0, 0}, 0.25f);
    EXPECT_LT(glm::length(eyeOf(camera) - glm::vec3(0, 0, 2)), 1e-5f);
    camera.orthographic = true;
    camera.ymag = 4;
    approach(camera, {0, 0, 0}, 0.5f);
    EXPECT_EQ(camera.ymag, 2);
}

TEST(SphereMap, PlacesAndDirectionsAreInverse) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 d = glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
        ASSERT_LT(glm::length(directionAt(placeOfDirection(d)) - d), 2e-3f);
    }
    EXPECT_LT(glm::length(directionAt({0.25f, 0.5f}) - glm::vec3(0, 1, 0)), 1e-5f);
    EXPECT_LT(glm::length(directionAt({0.6f, 0}) - glm::vec3(0, 0, 1)), 1e-5f); // row 0 is z = 1
}

TEST(SphereMap, FindsTheBrightestPixel) {
    Image map(8, 4, 1);
    EXPECT_FALSE(brightest(map));
    map.at(6, 1)[0] = 3;
    map.at(2, 2)[0] = 1;
    EXPECT_EQ(*brightest(map), glm::vec2(6.5f / 8, 1.5f / 4));
}

TEST(SphereMap, ProjectsAsCamerasSee) {
    const Camera camera = lookingAt({0, 0, 5}, {0, 0, 0});
    EXPECT_LT(glm::length(*project(camera, {0, 0, 0}, 200, 100) - glm::vec2(100, 50)), 1e-3f);
    const float half = 5 * std::tan(0.5f * camera.yfov);
    EXPECT_LT(glm::length(*project(camera, {0, half, 0}, 200, 100) - glm::vec2(100, 0)), 1e-2f);
    EXPECT_LT(glm::length(*project(camera, {2 * half, 0, 0}, 200, 100) - glm::vec2(200, 50)), 1e-2f);
    EXPECT_FALSE(project(camera, {0, 0, 6}, 200, 100));
}

} // namespace
} // namespace cmpg::viewer

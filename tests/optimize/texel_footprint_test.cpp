// How many texels a pixel sees along its edge, of squares before cameras.
#include "linear_model.h"
#include "optimize/texel_footprint.h"

#include <gtest/gtest.h>

namespace cmpg::test {
namespace {

// A square from -1 to 1 at z = 0 with a texture of 64 x 32 texels, seen from z = distance.
struct Square {
    Scene scene;
    Camera camera;

    explicit Square(float distance) {
        Geometry& g = scene.geometry;
        g.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        g.uv0 = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        g.triangles = {{{0, 1, 2}, 0}, {{0, 2, 3}, 0}};
        scene.parameters.push_back(makeParameter("square.baseColor", SlotKind::BaseColor, 64, 32, 3, 0.5f));
        scene.materials.emplace_back();
        scene.materials[0].parameters.fill(kNoParameter);
        scene.materials[0].parameters[std::size_t(SlotKind::BaseColor)] = 0;
        camera.toWorld[3] = glm::vec4(0, 0, distance, 1);
        camera.yfov = 2 * std::atan(0.5f); // two away it shows a square of two
    }
    TexelFootprint footprint(int width, int height) const {
        const CameraRays picture(camera, width, height);
        return texelFootprint(scene, 0, std::span(&picture, 1));
    }
    double texels(int width, int height) const { return footprint(width, height).mean; }
    double least(int width, int height) const { return footprint(width, height).least; }
};

TEST(TexelFootprint, IsTheRootOfTexelsByPixels) {
    const double all = std::sqrt(64 * 32 / (16.0 * 16.0));
    EXPECT_NEAR(Square(2).texels(16, 16), all, 1e-5);
    EXPECT_NEAR(Square(4).texels(16, 16), 2 * all, 1e-5);
    EXPECT_NEAR(Square(1).texels(16, 16), all / 2, 1e-5) << "a quarter of it fills the picture";
    EXPECT_NEAR(Square(2).texels(32, 16), all, 1e-5) << "and there is nothing beside it";
    EXPECT_EQ(Square(-2).texels(16, 16), 0) << "behind the camera";
}

TEST(TexelFootprint, FollowsCameraAndTexture) {
    Square square(3);
    square.camera.orthographic = true;
    square.camera.ymag = 2;
    EXPECT_NEAR(square.texels(16, 16), std::sqrt(64 * 32 / 64.0), 1e-5);
    square.camera.center = {0.5f, 0}; // a quarter of the picture to the right: all of it is still there
    EXPECT_NEAR(square.texels(16, 16), std::sqrt(64 * 32 / 64.0), 1e-5);
    square.scene.parameters[0].uvTransform = glm::mat3x2(3, 0, 0, 1, 0.2f, 0); // three copies beside each other
    EXPECT_NEAR(square.texels(16, 16), std::sqrt(3 * 64 * 32 / 64.0), 1e-5);
    square.scene.materials.push_back(square.scene.materials[0]); // the square's own material blends with the one that reads the texture
    std::swap(square.scene.materials[0].parameters[std::size_t(SlotKind::BaseColor)], square.scene.materials[0].parameters[std::size_t(SlotKind::Normal)]);
    EXPECT_EQ(square.texels(16, 16), 0);
    square.scene.materials[0].blendWith = 1;
    EXPECT_NEAR(square.texels(16, 16), std::sqrt(3 * 64 * 32 / 64.0), 1e-5);
    square.scene.parameters[0].kind = SlotKind::Roughness; // no surface has it
    EXPECT_EQ(square.texels(16, 16), 0);
}

TEST(TexelFootprint, LeastIsAlongTheShorterSide) {
    EXPECT_EQ(Square(2).least(15, 15), 2) << "4.3 x 2.1 texels";
    EXPECT_EQ(Square(2).least(7, 7), 4) << "9.1 x 4.6";
    EXPECT_EQ(Square(4).least(15, 15), 4);
    EXPECT_EQ(Square(2).least(100, 100), 0) << "a texel covers pixels";
    EXPECT_EQ(Square(-2).least(15, 15), 0);
    Square turned(2);
    for (glm::vec2& uv : turned.scene.geometry.uv0)
        uv = {0.5f * uv.y + 3, 1 - uv.x};
    EXPECT_EQ(turned.least(15, 15), 2) << "2.1 x 2.1";
}

// Seen at a slant, what a pixel covers is long, and shortest across where it is nearest.
TEST(TexelFootprint, LeastOfAFloorIsThatOfItsNearestPart) {
    Square square(2);
    square.scene.parameters[0] = makeParameter("square.baseColor", SlotKind::BaseColor, 51, 512, 3, 0.5f);
    for (glm::vec3& corner : square.scene.geometry.positions)
        corner = {0.1f * corner.x, -0.2f, -4 * corner.y - 4}; // from 2 to 10 before the camera
    // At a distance of 2 the picture is 2 wide: a pixel of 20 covers 25 texels across, and five times as many at the far end.
    EXPECT_EQ(square.least(20, 20), 16);
    const TexelFootprint all = square.footprint(20, 20);
    EXPECT_GT(all.mean, 4 * all.least);
}

// One picture of several that is nearer decides, if it shows more than a fiftieth.
TEST(TexelFootprint, LeastIsThatOfTheNearestPicture) {
    const Square far(20), near(2);
    Square nearest(0.05f);
    nearest.camera.toWorld[3] = glm::vec4(0.5f, 0.5f, 0.05f, 1);
    const CameraRays pictures[] = {{far.camera, 15, 15}, {near.camera, 15, 15}, {nearest.camera, 15, 15}};
    EXPECT_EQ(texelFootprint(far.scene, 0, std::span(pictures, 1)).least, 16);
    EXPECT_EQ(texelFootprint(far.scene, 0, std::span(pictures, 2)).least, 2);
    EXPECT_EQ(texelFootprint(far.scene, 0, pictures).least, 2) << "the last shows a thousandth";
}

// A floor that the picture cuts off: pixels are counted by rays, texels by where points of the floor are in the picture.
TEST(TexelFootprint, AgreesWithRaysAtASlant) {
    Square square(2);
    auto& p = square.scene.geometry.positions;
    for (glm::vec3& corner : p)
        corner = {corner.x, 0.3f * corner.y - 0.4f, -1.2f * corner.y - 0.2f};
    const CameraRays picture(square.camera, 40, 40);
    constexpr int kRays = 5; // along the edge of a pixel
    double pixels = 0, seen = 0;
    for (int y = 0; y < 40 * kRays; ++y)
        for (int x = 0; x < 40 * kRays; ++x)
            pixels += castRay(square.scene, picture.at((float(x) + 0.5f) / kRays, (float(y) + 0.5f) / kRays)) ? 1.0 / (kRays * kRays) : 0;
    constexpr int kPoints = 500; // along the edge of the floor
    for (int y = 0; y < kPoints; ++y)
        for (int x = 0; x < kPoints; ++x) {
            const glm::vec4 at = picture.project(p[0] + (float(x) + 0.5f) / kPoints * (p[1] - p[0]) + (float(y) + 0.5f) / kPoints * (p[3] - p[0]));
            seen += at.z > 0 && std::abs(at.x) <= at.w && std::abs(at.y) <= at.w ? 1.0 / (kPoints * kPoints) : 0;
        }
    EXPECT_GT(seen, 0.2);
    EXPECT_LT(seen, 0.9);
    const double expected = std::sqrt(64 * 32 * seen / pixels);
    EXPECT_NEAR(square.texels(40, 40), expected, 0.01 * expected);
}

TEST(SampleShare, FallsWhereTexelsCoverMoreThanFourPixels) {
    const auto share = [](std::initializer_list<double> means) {
        std::vector<TexelFootprint> footprints;
        for (const double mean : means)
            footprints.push_back({.mean = mean});
        return sampleShare(footprints);
    };
    EXPECT_EQ(share({}), 1);
    EXPECT_EQ(share({0}), 1) << "a constant, or an environment";
    EXPECT_EQ(share({2}), 1);
    EXPECT_EQ(share({0.5}), 1) << "four pixels a texel";
    EXPECT_EQ(share({0.375}), 0.5625);
    EXPECT_EQ(share({0.01}), 0.25) << "at least";
    EXPECT_EQ(share({0.01, 0.375}), 0.5625) << "the finest tells";
    EXPECT_EQ(share({0.01, 0}), 1);
}

} // namespace
} // namespace cmpg::test

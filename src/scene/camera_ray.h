// Rays of a camera and what they hit first, on the host: for single pixels.
#pragma once

#include "scene/scene.h"

#include <optional>

namespace cmpg {

// The rays through the pixels of a camera's picture, as generate_rays makes them.
class CameraRays {
  public:
    CameraRays(const Camera& camera, int width, int height);
    struct Ray {
        glm::vec3 origin, direction; // unit length
    };
    Ray at(float x, float y) const; // raster position: (0,0) is the top left corner of the top left pixel
    // Where a point is in the picture: (x w, y w, depth, w), with x and y from -1, left and below, to 1. Depth is above 0 before the camera; w is 1
    // of an orthographic camera, else the depth.
    glm::vec4 project(const glm::vec3& point) const;
    glm::dvec2 size() const { return {width_, height_}; } // in pixels
    double pixels() const { return double(width_) * height_; }

  private:
    int width_, height_;
    bool orthographic_;
    glm::vec3 origin_, right_, up_, forward_;
    glm::mat3 toPicture_; // from what is left of a point without the origin
};

struct SurfaceHit {
    float distance = 0;
    std::uint32_t triangle = 0;
    glm::vec3 position{0}, normal{0}; // the triangle's normal, towards the origin of the ray
};

// Tries every triangle: some milliseconds for a million. Holes of alpha masks are looked up by their nearest texel.
std::optional<SurfaceHit> castRay(const Scene& scene, const CameraRays::Ray& ray);

} // namespace cmpg

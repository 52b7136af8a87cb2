// --target: an image, and the camera it was taken by.
#pragma once

#include "scene/scene.h"
#include "session/options.h"

#include <cmpg/recovery.h>

namespace cmpg {

// Three channels, as the renderer takes an adjoint; of other images the first channel counts.
Image readColorImage(const std::string& file);

struct CameraFile {
    std::string camera; // empty: the one of --camera
    std::filesystem::path file;
};

// "FILE" or "CAMERA=FILE"; what stands before '=' counts as a camera only if the scene has it or no such file exists.
CameraFile cameraFileOf(const Scene& scene, const std::string& text);

// Its camera is empty where it is the one of --camera.
v1::Target openTarget(const Options& options, const v1::Scene& scene, const std::string& text);

} // namespace cmpg

// --target and --mask: images, and the cameras they are of.
#pragma once

#include "scene/scene.h"
#include "session/options.h"

#include <cmpg/recovery.h>

#include <span>

namespace cmpg {

// Three channels, as the renderer takes an adjoint; of other images the first channel counts.
Image readColorImage(const std::string& file);

struct CameraFile {
    std::string camera; // empty: the one of --camera
    std::filesystem::path file;
};

// "FILE" or "CAMERA=FILE"; what stands before '=' is a camera only if the scene has it or no such file exists.
CameraFile cameraFileOf(const Scene& scene, const std::string& text);

// The file of --mask for the target of a camera ("": that of --camera): the camera's own, or the one of all. Empty: there is none.
std::filesystem::path maskOf(const Options& options, const Scene& scene, const std::string& camera);

// Error(Usage) on a mask of a camera that none of `cameras` is, in whose names "" is that of --camera.
void requireMasksOf(const Options& options, const Scene& scene, std::span<const std::string> cameras);

// Error(Usage) where several targets do not say which camera they are of, of several.
void requireCamerasNamed(const Options& options, const Scene& scene);

// Warns of a target without colours, since each channel of the image is compared with it, and, where not both --width and --height are given, of one whose proportions
// are not its camera's. `camera`: empty: that of --camera.
void warnOfTarget(const Options& options, const Scene& scene, const std::string& camera, const v1::Target& target);

// As large as --width and --height ask for: photographs have more pixels than a recovery needs.
v1::Target averagedTo(const Options& options, v1::Target target);

// Its camera is empty where it is the one of --camera. Warns as above.
v1::Target openTarget(const Options& options, const v1::Scene& scene, const std::string& text);

} // namespace cmpg

// --target and --mask: images, and the cameras they are of.
#include "session/targets.h"

#include "base/error.h"
#include "base/log.h"
#include "library/states.h"
#include "scene/file_io.h"
#include "scene/image.h"
#include "scene/image_size.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

namespace cmpg {
namespace {

const std::string& nameOfCamera(const Options& options, const Scene& scene, const std::string& camera) {
    return scene.camera(camera.empty() ? options.camera : camera).name;
}

void warnOfGrey(const v1::Target& target) {
    const std::vector<float>& values = target.image.values;
    for (std::size_t i = 0; i + 2 < values.size(); i += 3)
        if (values[i] != values[i + 1] || values[i] != values[i + 2])
            return;
    if (!values.empty())
        logWarn("the target " + target.name + " is grey: it tells of no colours, and the image is compared with it in each channel");
}

// A view keeps the camera's height and takes the target's proportions.
void warnOfProportions(const v1::Target& target, const Camera& camera) {
    constexpr double kAlike = 1.03; // and a pixel, by which sizes are rounded
    const double aspect = aspectOf(camera).value_or(0), width = target.image.width, height = target.image.height, expected = aspect * height;
    if (aspect <= 0 || (width < expected * kAlike + 1 && expected < width * kAlike + 1))
        return;
    char text[160];
    std::snprintf(text, sizeof text, " is %.3g times as wide as high, the view of its camera in the scene %.3g times: it keeps its height. A target that was cropped does not fit",
                  width / height, aspect);
    logWarn("the target " + target.name + text);
}

} // namespace

Image readColorImage(const std::string& file) {
    Image image = readImage(file).image;
    if (image.channels == 3)
        return image;
    Image grey(image.width, image.height, 3);
    for (std::size_t i = 0; i < grey.values.size(); ++i)
        grey.values[i] = image.values[i / 3 * image.channels];
    return grey;
}

CameraFile cameraFileOf(const Scene& scene, const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals != std::string::npos) {
        const std::string camera = text.substr(0, equals);
        const bool known = std::any_of(scene.cameras.begin(), scene.cameras.end(), [&](const Camera& c) { return c.name == camera; });
        if (known || !fileExists(text)) {
            scene.camera(camera); // an error here names the cameras there are
            return {camera, text.substr(equals + 1)};
        }
    }
    return {"", text};
}

std::filesystem::path maskOf(const Options& options, const Scene& scene, const std::string& camera) {
    const std::string& name = nameOfCamera(options, scene, camera);
    std::filesystem::path ofAll;
    for (const std::string& text : options.mask) {
        const CameraFile given = cameraFileOf(scene, text);
        if (given.camera.empty())
            ofAll = given.file;
        else if (given.camera == name)
            return given.file;
    }
    return ofAll;
}

void requireMasksOf(const Options& options, const Scene& scene, std::span<const std::string> cameras) {
    for (const std::string& text : options.mask) {
        const CameraFile given = cameraFileOf(scene, text);
        const auto isOf = [&](const std::string& camera) { return nameOfCamera(options, scene, camera) == given.camera; };
        if (!given.camera.empty() && std::none_of(cameras.begin(), cameras.end(), isOf))
            throw Error(ErrorKind::Usage, "there is no target of the camera " + given.camera + " for the mask " + given.file.string(), {},
                        "give one, or leave the mask out", {"target", "mask"});
    }
}

void requireCamerasNamed(const Options& options, const Scene& scene) {
    if (options.target.size() <= 1 || scene.cameras.size() <= 1 || !options.camera.empty())
        return;
    for (const std::string& text : options.target)
        if (cameraFileOf(scene, text).camera.empty()) {
            std::string names;
            for (const Camera& camera : scene.cameras)
                names += (names.empty() ? "" : ", ") + camera.name;
            throw Error(ErrorKind::Usage, "the target " + text + " is of no camera by name, and there are several targets and cameras", "the cameras are " + names,
                        "give each as CAMERA=FILE", {"target"});
        }
}

void warnOfTarget(const Options& options, const Scene& scene, const std::string& camera, const v1::Target& target) {
    warnOfGrey(target);
    if (!options.width || !options.height)
        warnOfProportions(target, scene.camera(camera.empty() ? options.camera : camera));
}

v1::Target averagedTo(const Options& options, v1::Target target) {
    if (!options.width && !options.height)
        return target;
    return target.averaged(int(options.width.value_or(0)), int(options.height.value_or(0)));
}

v1::Target openTarget(const Options& options, const v1::Scene& scene, const std::string& text) {
    const Scene& host = scene.state()->scene;
    const CameraFile given = cameraFileOf(host, text);
    if (options.target.size() <= 1) // of several whoever opens them all knows which cameras they have
        requireMasksOf(options, host, std::span(&given.camera, 1));
    v1::Target target = v1::Target::load(given.file, given.camera, maskOf(options, host, given.camera), options.targetExposure);
    warnOfTarget(options, host, given.camera, target);
    return target;
}

} // namespace cmpg

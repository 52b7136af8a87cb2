// --target: an image, and the camera it was taken by.
#include "session/targets.h"

#include "library/states.h"
#include "scene/file_io.h"
#include "scene/image.h"

#include <algorithm>
#include <filesystem>

namespace cmpg {

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

v1::Target openTarget(const Options& options, const v1::Scene& scene, const std::string& text) {
    const CameraFile given = cameraFileOf(scene.state()->scene, text);
    return v1::Target::load(given.file, given.camera, options.mask, options.targetExposure);
}

} // namespace cmpg

// --target: an image, and the camera it was taken by.
#include "app/targets.h"

#include <algorithm>
#include <filesystem>

namespace cmpg {

CameraTarget loadCameraTarget(const Options& options, const Scene& scene, const std::string& text) {
    const TargetOptions how{.mask = options.mask, .exposure = options.targetExposure};
    const std::size_t equals = text.find('=');
    if (equals != std::string::npos) {
        const std::string camera = text.substr(0, equals);
        const bool known = std::any_of(scene.cameras.begin(), scene.cameras.end(), [&](const Camera& c) { return c.name == camera; });
        if (known || !std::filesystem::exists(text)) {
            scene.camera(camera); // an error here names the cameras there are
            return {camera, loadTarget(text.substr(equals + 1), how)};
        }
    }
    return {"", loadTarget(text, how)};
}

} // namespace cmpg

// What the tests of the library's surface share: the box, a device, and the program, whose files are the yardstick.
#pragma once

#include "support/temp_folder.h"

#include <cmpg/cmpg.h>

#include <cstdlib>
#include <gtest/gtest.h>
#include <unistd.h>

namespace cmpg::test {

inline const std::string kBox = CMPG_SOURCE_DIR "/scenes/box/scene.gltf";
inline const std::string kPainting = "painting.baseColor"; // 64 x 64 x 3

inline Device& device() {
    static Device d;
    return d;
}

class Folder {
  public:
    std::string operator/(const std::string& name) const { return folder_ / name; }

  private:
    TempFolder folder_;
};

// Runs the program; whether it ended well.
inline bool program(const std::string& arguments) {
    return std::system((std::string(CMPG_BINARY) + " --headless --quiet " + arguments + " > /dev/null 2>&1").c_str()) == 0;
}

inline Scene greyScene() {
    Scene scene = Scene::load(kBox);
    scene.set(kPainting, std::vector{0.5f});
    return scene;
}

inline RecoveryOptions paintingOptions() {
    RecoveryOptions options;
    options.parameters = {kPainting};
    options.paths.maxDepth = 4;
    return options;
}

inline RendererOptions paintingRenderer(bool recoveries = true) {
    RendererOptions options;
    options.paths.maxDepth = 4;
    options.parameters = {kPainting};
    options.recoveries = recoveries;
    return options;
}

// A picture of the true scene, small.
inline Target smallTarget(std::uint64_t seed = 1) { return {"", Renderer(device(), Scene::load(kBox)).render({.width = 32, .spp = 32, .seed = seed})}; }

inline Error errorOf(const auto& action) {
    try {
        action();
    } catch (const Error& error) {
        return error;
    }
    ADD_FAILURE() << "nothing was thrown";
    return {ErrorKind::Usage, ""};
}

} // namespace cmpg::test

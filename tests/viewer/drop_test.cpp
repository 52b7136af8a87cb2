// Files dropped on the window: the display's callback, and what becomes of them. Needs a display; drive_viewer.py gives it one.
#include "viewer/desk.h"
#include "viewer/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <chrono>
#include <cstdlib>
#include <gtest/gtest.h>
#include <thread>

namespace cmpg::viewer {
namespace {

const std::string kScenes = std::string(CMPG_SOURCE_DIR) + "/scenes/";

// Drops as the display does: by the callback that the window gave it.
void drop(Window& window, std::vector<const char*> files) {
    const GLFWdropfun callback = glfwSetDropCallback(window.handle(), nullptr);
    callback(window.handle(), int(files.size()), files.data());
    glfwSetDropCallback(window.handle(), callback);
}

template <class Condition> bool waitFor(Desk& desk, Condition&& condition) {
    for (int i = 0; i < 2400; ++i) { // four minutes: kernels are compiled
        desk.update();
        if (condition(*desk.state))
            return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return false;
}

TEST(Drop, OpensScenesAndTargets) {
    std::unique_ptr<Window> window;
    try {
        window = std::make_unique<Window>("drop test", 640, 480);
    } catch (const Error& error) {
        ASSERT_FALSE(std::getenv("CMPG_NEED_DISPLAY")) << error.what();
        GTEST_SKIP() << "no display: " << error.cause;
    }
    Options options;
    options.command = Command::Open;
    options.input = kScenes + "box/scene.gltf";
    options.width = 32;
    options.spp = 1;
    LiveSession session(options);
    Desk desk(session);
    ASSERT_TRUE(waitFor(desk, [](const LiveState& s) { return s.scene != nullptr; }));
    const auto dropped = [&](std::vector<const char*> files) {
        drop(*window, std::move(files));
        for (const auto& together : window->takeDropped())
            desk.open(together);
    };

    dropped({(kScenes + "bowl/scene.gltf").c_str()});
    EXPECT_TRUE(waitFor(desk, [](const LiveState& s) { return s.scene && s.scene->file.find("bowl") != std::string::npos; }));

    session.change([](LiveSettings& s) { s.mode = LiveMode::Optimize; });
    const std::string target = kScenes + "bowl/target.exr";
    dropped({target.c_str()});
    EXPECT_TRUE(waitFor(desk, [&](const LiveState& s) { return s.targets.size() == 1 && s.picture(LivePicture::Target); }));

    dropped({(kScenes + "README.md").c_str()});
    EXPECT_NE(desk.fileError.find("README.md"), std::string::npos);
    const std::uint32_t errors = desk.state->error.number;
    dropped({"/nonexistent/scene.glb"}); // says so, and keeps what was there
    EXPECT_TRUE(waitFor(desk, [&](const LiveState& s) { return s.error.number > errors; }));
    EXPECT_NE(desk.state->scene->file.find("bowl"), std::string::npos);

    // A scene and its target in one drop, in either order.
    const std::string box = kScenes + "box/scene.gltf", door = kScenes + "door/scene.gltf";
    const auto shows = [&](const char* scene) {
        return waitFor(desk, [&](const LiveState& s) { return s.scene->file.find(scene) != std::string::npos && s.targets == std::vector{target}; });
    };
    dropped({target.c_str(), box.c_str()});
    EXPECT_TRUE(shows("box"));
    dropped({door.c_str(), target.c_str()});
    EXPECT_TRUE(shows("door"));
    EXPECT_FALSE(desk.openError());
}

} // namespace
} // namespace cmpg::viewer

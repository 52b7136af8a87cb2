// A window of the display: its events, size and drops.
#include "viewer/window.h"

#include "base/error.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <utility>

namespace cmpg::viewer {
namespace {

[[noreturn]] void refuse(const std::string& what) {
    const char* reason = nullptr;
    glfwGetError(&reason);
    throw Error(ErrorKind::Device, what, reason ? reason : "there is no display",
                "work without a window: cmpg-vk --headless COMMAND SCENE ...; cmpg-vk --help lists the commands");
}

Window& windowOf(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
}

// No larger than the monitor: without a window manager, or with a simple one, the rest could not be reached.
void fitMonitor(GLFWwindow* window) {
    int width, height, mostWidth = 0, mostHeight = 0;
    if (GLFWmonitor* const monitor = glfwGetPrimaryMonitor())
        glfwGetMonitorWorkarea(monitor, nullptr, nullptr, &mostWidth, &mostHeight);
    glfwGetWindowSize(window, &width, &height);
    if (mostWidth > 0 && mostHeight > 0 && (width > mostWidth || height > mostHeight))
        glfwSetWindowSize(window, std::min(width, mostWidth), std::min(height, mostHeight));
}

} // namespace

Window::Window(const std::string& title, int width, int height) : title_(title) {
    if (!glfwInit())
        refuse("no window can be opened");
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (!window_) {
        glfwTerminate();
        refuse("no window can be opened");
    }
    fitMonitor(window_);
    constexpr int kLeastWidth = 480, kLeastHeight = 320;
    glfwSetWindowSizeLimits(window_, kLeastWidth, kLeastHeight, GLFW_DONT_CARE, GLFW_DONT_CARE);
    glfwSetWindowUserPointer(window_, this);
    // Whatever happens asks for frames. Dear ImGui chains to these.
    glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double, double) { windowOf(w).requestFrames(); });
    glfwSetCursorEnterCallback(window_, [](GLFWwindow* w, int) { windowOf(w).requestFrames(); });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int, int, int) { windowOf(w).requestFrames(); });
    glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double) { windowOf(w).requestFrames(); });
    glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int modifiers) {
        if (action == GLFW_PRESS)
            windowOf(w).keys_.push_back({key, (modifiers & GLFW_MOD_CONTROL) != 0, (modifiers & GLFW_MOD_SHIFT) != 0});
        windowOf(w).requestFrames();
    });
    glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned int) { windowOf(w).requestFrames(); });
    glfwSetWindowFocusCallback(window_, [](GLFWwindow* w, int) { windowOf(w).requestFrames(); });
    glfwSetWindowIconifyCallback(window_, [](GLFWwindow* w, int) { windowOf(w).requestFrames(); });
    glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { windowOf(w).requestFrames(); });
    glfwSetFramebufferSizeCallback(window_, [](GLFWwindow* w, int, int) { windowOf(w).requestFrames(); });
    glfwSetWindowContentScaleCallback(window_, [](GLFWwindow* w, float, float) { windowOf(w).requestFrames(); });
    glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** files) { windowOf(w).drop({files, files + count}); });
}

Window::~Window() {
    glfwDestroyWindow(window_);
    glfwTerminate();
}

bool Window::closing() const {
    return glfwWindowShouldClose(window_);
}

void Window::close() {
    glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

void Window::setTitle(const std::string& title) {
    if (title == title_)
        return;
    title_ = title;
    glfwSetWindowTitle(window_, title.c_str());
}

bool Window::minimised() const {
    return glfwGetWindowAttrib(window_, GLFW_ICONIFIED);
}

float Window::scale() const {
    float x = 1, y = 1;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::clamp(std::max(x, y), 0.5f, 8.f);
}

void Window::wait(double seconds) {
    if (seconds > 0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
}

void Window::wake() {
    glfwPostEmptyEvent();
}

bool Window::takeFrame() {
    if (frames_ == 0)
        return false;
    --frames_;
    return true;
}

void Window::requestFrames(int frames) {
    frames_ = std::max(frames_, frames);
}

void Window::drop(std::vector<std::filesystem::path> files) {
    dropped_.push_back(std::move(files));
    requestFrames();
}

std::vector<KeyPress> Window::takeKeys() {
    return std::exchange(keys_, {});
}

std::vector<std::vector<std::filesystem::path>> Window::takeDropped() {
    return std::exchange(dropped_, {});
}

} // namespace cmpg::viewer

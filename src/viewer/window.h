// A window of the display: its events, size and drops. Draws nothing.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

struct GLFWwindow;

namespace cmpg::viewer {

class Window {
  public:
    // Error(Device) that names --headless where there is no display.
    Window(const std::string& title, int width, int height);
    ~Window();
    Window(const Window&) = delete;

    GLFWwindow* handle() const { return window_; }
    bool closing() const;
    void close();
    bool minimised() const;
    float scale() const; // of the display: 1 at about 96 dots an inch

    // Until something happens, or wake(), or this time is over.
    void wait(double seconds);
    static void wake(); // from any thread
    // Frames still to be drawn since the last event: an interface needs a few to settle.
    bool takeFrame();
    void requestFrames(int frames = 3);

    // Files dropped since the last call.
    std::vector<std::filesystem::path> takeDropped();
    // What the display's drop event calls.
    void drop(std::vector<std::filesystem::path> files);

  private:
    GLFWwindow* window_ = nullptr;
    int frames_ = 3;
    std::vector<std::filesystem::path> dropped_;
};

} // namespace cmpg::viewer

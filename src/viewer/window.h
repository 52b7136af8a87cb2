// A window of the display: its events, size and drops. Draws nothing.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

struct GLFWwindow;

namespace cmpg::viewer {

// A key that went down: GLFW's number of it.
struct KeyPress {
    int key = 0;
    bool control = false, shift = false;
};

class Window {
  public:
    // Error(Device) that names --headless where there is no display.
    Window(const std::string& title, int width, int height);
    ~Window();
    Window(const Window&) = delete;

    GLFWwindow* handle() const { return window_; }
    bool closing() const;
    void close();
    void setTitle(const std::string& title);
    bool minimised() const;
    float scale() const; // of the display: 1 at about 96 dots an inch

    // Until something happens, or wake(), or this time is over.
    void wait(double seconds);
    static void wake(); // from any thread
    // Frames still to be drawn since the last event: an interface needs a few to settle.
    bool takeFrame();
    bool framesDue() const { return frames_ > 0; }
    void requestFrames(int frames = 3);

    // Keys that went down since the last call. Frames may take longer than a key is held, so that its state tells nothing.
    std::vector<KeyPress> takeKeys();
    // Files dropped since the last call, drop by drop.
    std::vector<std::vector<std::filesystem::path>> takeDropped();
    // What the display's drop event calls.
    void drop(std::vector<std::filesystem::path> files);

  private:
    GLFWwindow* window_ = nullptr;
    int frames_ = 3;
    std::string title_;
    std::vector<KeyPress> keys_;
    std::vector<std::vector<std::filesystem::path>> dropped_;
};

} // namespace cmpg::viewer

// Images for another program to show while a run goes on: docs/display-stream.md has the layout of what is sent.
#pragma once

#include "scene/image.h"

#include <memory>
#include <string>

namespace cmpg {

class DisplayStream {
  public:
    // "HOST:PORT" or "HOST", which means port 14158; an IPv6 address stands in brackets. Error(Usage) on anything else. Nothing is sent
    // where `address` is empty. `title` stands before the names of all images.
    explicit DisplayStream(const std::string& address, const std::string& title = {});
    // Waits for the last images to be sent, a second at most.
    ~DisplayStream();
    DisplayStream(const DisplayStream&) = delete;
    DisplayStream& operator=(const DisplayStream&) = delete;

    bool active() const { return impl_ != nullptr; }
    // Takes a copy and returns; what the same name showed and is still waiting to be sent is dropped. A display that is slow, absent or
    // goes away costs the run nothing but a warning.
    void show(const std::string& name, const Image& image);

    static void requireAddress(const std::string& address); // the check alone

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace cmpg

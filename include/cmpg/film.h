// An image that grows with the passes that add to it.
#pragma once

#include <cmpg/image.h>
#include <cmpg/namespace.h>
#include <cmpg/report.h>

#include <cstdint>
#include <memory>

namespace cmpg::v1 {

// The sums over the samples of every pixel. Samples may come in any number of passes (Renderer, Recovery): they leave the bits that one pass would have left.
// A handle: copies are the same film. What reads it waits for a pass of another thread that adds to it; what that pass calls may read it.
class Film {
  public:
    Film(); // of no pixels
    // From 1 to 32768 pixels each. `layers`: passes of images keep what the camera sees first as well.
    Film(int width, int height, bool layers = false);

    int width() const;
    int height() const;
    std::size_t pixels() const { return std::size_t(width()) * std::size_t(height()); }
    bool hasLayers() const;
    std::uint32_t samples() const; // per pixel, so far

    // The mean of the samples, height x width x 3, linear. Error(Usage) where there are none yet.
    Image image() const;
    // The same of Layers. Error(Usage) where the film has none, or no samples yet.
    Layers layers() const;

    struct State;
    const std::shared_ptr<State>& state() const { return state_; }

  private:
    std::shared_ptr<State> state_;
};

} // namespace cmpg::v1

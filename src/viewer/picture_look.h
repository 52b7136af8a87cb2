// How values become colours, and which value gets the deepest: one rule for panels, legends and saved files.
#pragma once

#include "live/live_session.h"
#include "viewer/present/panel_quad.h"

#include <map>

namespace cmpg::viewer {

enum class ScaleRule {
    Automatic, // every signed picture its own, as `view --signed` chooses it
    Shared,    // the largest of these for all signed pictures that are shown
    Fixed,     // one value for all
};

struct LookSettings {
    float exposure = 0; // stops
    ScaleRule rule = ScaleRule::Automatic;
    float fixedScale = 1;
};

struct PictureLook {
    gpu::uint kind = gpu::kPanelColor;
    double scale = 0; // value at the end of the legend; 0: no legend
    bool isSigned = false;
    float factor = 1;
};

class Looks {
  public:
    LookSettings settings;

    // Once a frame: finds the scales of what `state` shows of these pictures.
    void update(const LiveState& state, std::span<const LivePicture> pictures);
    PictureLook of(const LiveState& state, LivePicture picture) const;
    LiveLook forFile(const LiveState& state, LivePicture picture) const;

  private:
    struct Measured {
        std::shared_ptr<const Image> image;
        double scale = 1;
    };
    std::map<LivePicture, Measured> measured_; // kept while a picture stays the same: a percentile takes a while
    double shared_ = 1;
};

} // namespace cmpg::viewer

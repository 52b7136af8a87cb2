// An image in the window: where it stands and how its values become colours. Drawn under the interface.
#pragma once

#include "shared/panel.h"

#include <cmpg/image.h>

#include <glm/glm.hpp>
#include <memory>

namespace cmpg::viewer {

// Pixels of the framebuffer, y down.
struct Rectangle {
    float x = 0, y = 0, width = 0, height = 0;

    float right() const { return x + width; }
    float bottom() const { return y + height; }
    bool contains(glm::vec2 p) const { return p.x >= x && p.y >= y && p.x < right() && p.y < bottom(); }
};

struct PanelQuad {
    std::shared_ptr<const Image> image; // null for kPanelPlain
    Rectangle place;                    // of the whole image
    Rectangle clip;                     // what of it may be seen
    gpu::uint kind = gpu::kPanelColor;
    float factor = 1, decades = 4, opacity = 1; // as in gpu::PanelPush
    glm::vec4 background{0, 0, 0, 1};
};

} // namespace cmpg::viewer

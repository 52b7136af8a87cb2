// The options as the renderer has them: for what builds on it and not on the library's surface.
#pragma once

#include "render/renderer.h"
#include "session/options.h"

namespace cmpg {

// How a renderer of the scene is built, as far as options say it.
RenderConfig renderConfig(const Options& options, const Scene& scene, const std::vector<std::uint32_t>& differentiable);

} // namespace cmpg

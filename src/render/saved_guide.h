// The guide of a renderer as a file of a scene: read with what must agree, and written.
#pragma once

#include "render/guided_passes.h"

namespace cmpg {

// Error(Input) where it was learned with other triangles or, where `parameters` is given, for other ones.
LoadedGuide readGuide(const std::filesystem::path& file, const Scene& scene, const std::vector<std::uint32_t>* parameters);
void writeGuide(const std::filesystem::path& file, const Scene& scene, const std::vector<std::uint32_t>& parameters, const Renderer& renderer,
                const GuidedPasses& passes);

} // namespace cmpg

// What the texels of a texture that no camera sees are expected to be.
#pragma once

#include "optimize/coarse_texture.h"
#include "optimize/regularizer.h"
#include "optimize/seen_texels.h"

#include <memory>

namespace cmpg {

// By how much neighbours of which images tell of none or one are expected to differ, from the pattern of the values that they tell of (guessTexture). Null where
// they are expected to be alike: the pattern is no better, the texture has more than 1024 x 1024 texels, or not all that cameras see is kept. `coarse`: from the
// texture to the grid that `seen` is of, and the pattern as well; null: its own.
std::shared_ptr<const ExpectedDifferences> expectUnseen(const Parameter& parameter, const SeenTexels& seen, const CoarseTexture* coarse = nullptr);

} // namespace cmpg

// What texels that no image tells are likely to be, from those that images tell.
#pragma once

#include "optimize/coarse_texture.h"

#include <optional>
#include <span>
#include <vector>

namespace cmpg {

// Textures repeat themselves: planks, tiles, threads. What the told texels have in common with those at a distance from them, their autocovariance, goes on
// where nothing is told: the best linear guess from all of them (simple kriging, Matheron 1963).
//
// `values`: entries() of the grid; `told`: by texel. Returns entries(), for told texels what the others and the covariance make of them. None where too few are
// told or untold, or where the guess is no better than a smooth surface through the told ones: both are tried on told texels that are left out.
std::optional<std::vector<float>> guessTexture(const TextureGrid& grid, std::span<const float> values, const std::vector<bool>& told);

} // namespace cmpg

// Passes of an estimate in batches: their random numbers, and their results as plain vectors.
#pragma once

#include "optimize/error_budget.h"
#include "render/renderer.h"

#include <span>

namespace cmpg {

// Random numbers of a part. `continues`: those of a batch's stages are one sequence, as passes allow that give all pixels equally many
// samples; otherwise each stage has numbers of its own.
PassKey partKey(const PassKey& key, const BatchPart& part, std::uint32_t batches, bool continues);

Image toImage(const std::vector<double>& values, int width, int height);
std::vector<double> fromImage(const Image& image);

// Gradients of several parameters in a row, and back.
std::vector<double> joined(const std::vector<std::vector<double>>& gradients);
void divide(std::span<const double> values, std::vector<std::vector<double>>& gradients);

} // namespace cmpg

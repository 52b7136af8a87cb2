// Passes of a command in batches, as --batches, --error-target and --time-budget want them.
#pragma once

#include "base/error.h"
#include "lab/error_budget.h"
#include "session/exit_status.h"
#include "session/session.h"

namespace cmpg {

// For results of at most `spp` samples per pixel in all.
SampleBudget sampleBudget(const Options& options, const Report& report, std::uint32_t spp);

// Random numbers of a part. `continues`: those of a batch's stages are one sequence, as passes allow that give all pixels equally many
// samples; otherwise each stage has numbers of its own.
PassKey partKey(const PassKey& key, const BatchPart& part, std::uint32_t batches, bool continues);

Image toImage(const std::vector<double>& values, int width, int height);
std::vector<double> fromImage(const Image& image);

// Gradients of several parameters in a row, and back.
std::vector<double> joined(const std::vector<std::vector<double>>& gradients);
void divide(std::span<const double> values, std::vector<std::vector<double>>& gradients);

// Prints the error, adds it to the report, and writes the samples that were taken to run.json, where `samples` is the option for them.
// CheckFailed where there is an error target that was not reached.
ExitStatus conclude(const BudgetedEstimate& estimate, const Options& options, Report& report, Session& session,
                  std::optional<std::uint32_t> Options::* samples);

} // namespace cmpg

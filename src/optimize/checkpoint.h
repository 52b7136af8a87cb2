// All that an optimisation needs to go on as if it had not ended.
#pragma once

#include "optimize/checkpoint_file.h"
#include "optimize/optimize.h"

#include <optional>

namespace cmpg {

struct Checkpoint {
    // What the run was: options, scene and targets, by name. Runs whose entries agree have the same results.
    using Identity = std::vector<std::pair<std::string, std::string>>;

    Identity identity;
    std::string config;   // the options, as in run.json
    std::string madeWith; // device and driver, whose rounding the bits depend on
    OptimizeState state;
    std::vector<std::vector<float>> values;     // of the optimised parameters, in their order
    std::vector<std::vector<double>> gradients; // of the last step
    Bytes learned;                              // ImageModel::save()
};

// Of a run as it is between two steps. What the passes of a step read from the steps before is all in here; random numbers and units of sums
// are functions of the seed, the step and the rest.
std::vector<FileSection> checkpointSections(const Optimization& run, const ImageModel& model, const Checkpoint::Identity& identity,
                                            const std::string& config, const std::string& madeWith);
// Error(Input) on sections that are none of a checkpoint.
Checkpoint readCheckpoint(const std::vector<FileSection>& sections);
// Error(Input) where it does not fit the run; the run is then as it was.
void resume(const Checkpoint& checkpoint, Optimization& run, ImageModel& model);

// The newest checkpoint of a folder that can be read. `refused`: why newer ones cannot, one line each.
std::optional<Checkpoint> findCheckpoint(const std::filesystem::path& folder, std::vector<std::string>& refused);

} // namespace cmpg

// The options that trade speed for accuracy, and the settings of them that a measurement tries.
#pragma once

#include "session/options.h"

#include <nlohmann/json.hpp>

namespace cmpg {

struct Knob {
    enum class Needs { Nothing, Steps, Reverse, Guide, Roulette }; // what has to be in use for it to matter
    std::string option; // without the dashes, as in run.json
    std::vector<nlohmann::json> values; // to try beside the default
    std::string what;   // the report's heading
    Needs needs = Needs::Nothing;
};

// For a scene that asks for `depth` segments. Values lie around those of `base`: by factors, or all others there are.
std::vector<Knob> tradeoffKnobs(const Options& base, std::uint32_t depth);

struct KnobChange {
    std::string option;
    nlohmann::json value;
    std::string text() const; // "--max-depth 4", "--no-nee"
};

struct Setting {
    std::vector<KnobChange> changes; // of the defaults; none: the defaults
    Options options;
    std::string name() const; // the changes, or "defaults"
};
Setting makeSetting(const Options& base, std::vector<KnobChange> changes);

// One knob at a time. `unused`: receives the options of knobs that would change nothing.
struct KnobUse {
    bool steps = false, reverse = false, guide = false, roulette = false; // what the defaults use here
};
std::vector<Setting> singleSettings(const Options& base, std::uint32_t depth, const KnobUse& use, std::vector<std::string>& unused);

// All pairs of `best`, changes of different knobs; where there are more than two, all of them together, and all but each one, which tells what that one
// is worth beside the others.
std::vector<Setting> combinedSettings(const Options& base, const std::vector<KnobChange>& best);

} // namespace cmpg

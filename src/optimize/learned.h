// What an optimisation's passes have learned, as bytes.
#pragma once

#include "base/byte_stream.h"
#include "guiding/field/sd_tree.h"
#include "guiding/policy/sampling_policy.h"

#include <optional>

namespace cmpg {

struct Learned {
    GuidedState state;
    std::optional<SdTree> tree;
};

void putLearned(ByteWriter& out, const GuidedState& state, const SdTree* tree);
Learned getLearned(ByteReader& in); // Malformed where it is not what putLearned() writes

} // namespace cmpg

// What an optimisation's passes have learned, as bytes.
#pragma once

#include "base/byte_stream.h"
#include "guiding/sd_tree.h"
#include "render/guided_passes.h"

#include <optional>

namespace cmpg {

struct Learned {
    GuidedState state;
    std::optional<SdTree> tree;
};

void putLearned(ByteWriter& out, const GuidedState& state, const SdTree* tree);
Learned getLearned(ByteReader& in); // Malformed where it is not what putLearned() writes

} // namespace cmpg

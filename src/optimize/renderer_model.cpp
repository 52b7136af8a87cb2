// What an optimisation's passes have learned, kept and taken up again.
#include "optimize/renderer_model.h"

#include "optimize/learned.h"

namespace cmpg {

void RendererModel::save(ByteWriter& out) const { putLearned(out, passes_.state(), renderer_.hasGuide() ? &renderer_.guide() : nullptr); }

void RendererModel::restore(ByteReader& in, std::uint32_t steps) {
    Learned learned = getLearned(in);
    if (learned.tree.has_value() != renderer_.hasGuide())
        throw Malformed{"it has a guide where there is none, or none where there is one"};
    passes_.restore(std::move(learned.state), std::move(learned.tree));
    step_ = steps;
    if (freeze_ != ~0u)
        passes_.setLearning(learns_ && step_ < freeze_);
}

} // namespace cmpg

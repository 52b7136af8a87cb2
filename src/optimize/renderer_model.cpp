// What an optimisation's passes have learned, as bytes.
#include "optimize/renderer_model.h"

#include "guiding/guide_file.h"

namespace cmpg {
namespace {

void put(ByteWriter& out, const SamplingChoice::State& choice) {
    out.count(choice.figures.size());
    for (const SamplingFigures& figures : choice.figures)
        putFigures(out, figures);
    out.put(std::uint64_t(choice.last));
}

SamplingChoice::State getChoice(ByteReader& in) {
    SamplingChoice::State choice;
    choice.figures.resize(in.count(2 * 8 + 4));
    for (SamplingFigures& figures : choice.figures)
        figures = getFigures(in);
    choice.last = std::size_t(in.get<std::uint64_t>());
    return choice;
}

} // namespace

void RendererModel::save(ByteWriter& out) const {
    const GuidedState state = passes_.state();
    put(out, state.images);
    put(out, state.derivatives);
    out.put(state.reference);
    out.put(std::uint8_t(state.trained));
    out.put(state.step);
    out.put(std::uint8_t(renderer_.hasGuide()));
    if (renderer_.hasGuide())
        putTree(out, renderer_.guide());
}

void RendererModel::restore(ByteReader& in, std::uint32_t steps) {
    GuidedState state;
    state.images = getChoice(in);
    state.derivatives = getChoice(in);
    state.reference = in.figure("the reference of the roulette");
    state.trained = in.get<std::uint8_t>() != 0;
    state.step = in.get<std::uint32_t>();
    std::optional<SdTree> tree;
    if (in.get<std::uint8_t>() != 0)
        tree = getTree(in);
    in.end();
    if (tree.has_value() != renderer_.hasGuide())
        throw Malformed{"it has a guide where there is none, or none where there is one"};
    passes_.restore(std::move(state), std::move(tree));
    step_ = steps;
    if (step_ >= freeze_)
        passes_.setLearning(false);
}

} // namespace cmpg

// What an optimisation's passes have learned, as bytes.
#include "optimize/learned.h"

#include "guiding/guide_file.h"

namespace cmpg {
namespace {

void put(ByteWriter& out, const SamplingChoice::State& choice) {
    out.count(choice.figures.size());
    for (const SamplingFigures& figures : choice.figures)
        putFigures(out, figures);
    for (const double ratio : choice.ratios)
        out.put(ratio);
    out.put(std::uint64_t(choice.last));
    out.put(choice.learned);
    out.put(choice.tried);
    out.put(choice.rough);
}

SamplingChoice::State getChoice(ByteReader& in) {
    SamplingChoice::State choice;
    choice.figures.resize(in.count(2 * 8 + 4 + 8));
    choice.ratios.resize(choice.figures.size());
    for (SamplingFigures& figures : choice.figures)
        figures = getFigures(in);
    for (double& ratio : choice.ratios)
        ratio = in.figure("how passes of a method differ");
    choice.last = std::size_t(in.get<std::uint64_t>());
    choice.learned = in.get<std::uint32_t>();
    choice.tried = in.get<std::uint32_t>();
    choice.rough = in.get<std::uint32_t>();
    return choice;
}

void put(ByteWriter& out, const Exploration::State& exploration) {
    out.put(exploration.noise);
    out.put(exploration.watched);
    out.put(std::uint8_t(exploration.urgent));
    out.put(exploration.spent);
    out.put(exploration.trials);
}

Exploration::State getExploration(ByteReader& in) {
    Exploration::State exploration;
    exploration.noise = in.figure("the noise of plain passes");
    exploration.watched = in.get<std::uint32_t>();
    exploration.urgent = in.get<std::uint8_t>() != 0;
    exploration.spent = in.figure("the rays so far");
    exploration.trials = in.figure("the rays of trials");
    return exploration;
}

} // namespace

void putLearned(ByteWriter& out, const GuidedState& state, const SdTree* tree) {
    put(out, state.images);
    put(out, state.derivatives);
    put(out, state.exploration);
    out.put(state.reference);
    out.put(std::uint8_t(state.trained));
    out.put(state.step);
    out.put(std::uint8_t(tree != nullptr));
    if (tree)
        putTree(out, *tree);
}

Learned getLearned(ByteReader& in) {
    Learned learned;
    learned.state.images = getChoice(in);
    learned.state.derivatives = getChoice(in);
    learned.state.exploration = getExploration(in);
    learned.state.reference = in.figure("the reference of the roulette");
    learned.state.trained = in.get<std::uint8_t>() != 0;
    learned.state.step = in.get<std::uint32_t>();
    if (in.get<std::uint8_t>() != 0)
        learned.tree = getTree(in);
    in.end();
    return learned;
}

} // namespace cmpg

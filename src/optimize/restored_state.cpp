// How an optimisation goes on from the state of another: whether that is one of its parameters and views.
#include "base/error.h"
#include "optimize/optimize.h"

namespace cmpg {

void Optimization::requireFits(const OptimizeState& state, const std::vector<std::vector<float>>& values,
                               const std::vector<std::vector<double>>& gradients) const {
    const bool begun = !state.history.empty();
    bool fits = values.size() == parameters_.size() && gradients.size() == (begun ? parameters_.size() : 0) && state.moments.size() == parameters_.size();
    for (std::size_t i = 0; fits && i < parameters_.size(); ++i) {
        const std::size_t entries = scene_.parameters[parameters_[i]].entries();
        const Moments& moments = state.moments[i];
        fits = values[i].size() == entries && (!begun || gradients[i].size() == entries) && moments.first.size() == entries &&
               moments.second.size() == state_.moments[i].second.size() && (moments.peak.empty() || moments.peak.size() == entries) &&
               !moments.noise.empty() &&
               moments.areOf(stepGrid(i));
    }
    fits = fits && state.imageValues.size() == state.images.size() && (state.images.empty() || state.images.size() == model_.views());
    for (std::size_t view = 0; fits && view < state.images.size(); ++view) {
        fits = state.images[view].empty() == !state.imageValues[view];
        for (std::size_t i = 0; fits && state.imageValues[view] && i < values.size(); ++i)
            fits = state.imageValues[view]->values.size() == values.size() && state.imageValues[view]->values[i].size() == values[i].size();
    }
    const std::size_t constants = constantUnits().size();
    const ConstantCurvature& curvature = state.constants;
    fits = fits && (curvature.empty() || curvature.matrix.size() == constants * constants) && curvature.noise.size() == curvature.matrix.size() &&
           curvature.others.size() == (curvature.empty() ? 0 : constants) && curvature.at.size() == curvature.others.size();
    const CarriedGradient& carried = state.carried;
    fits = fits && (carried.mean.empty() || carried.mean.size() == constants) && carried.variance.size() == carried.mean.size() &&
           carried.squares.size() == carried.mean.size() && carried.at.size() == carried.mean.size();
    fits = fits && state.cross.size() == coupled_.size();
    for (std::size_t place = 0; fits && place < coupled_.size(); ++place)
        fits = state.cross[place].below.empty() || state.cross[place].below.size() == crossEntries(coupled_[place]);
    fits = fits && (state.losses.empty() || state.losses.size() == model_.views());
    fits = fits && (state.pixelShares.empty() || state.pixelShares.size() == model_.views());
    for (std::size_t view = 0; fits && view < model_.views(); ++view) {
        const auto [width, height] = model_.size(view);
        if (!state.images.empty() && !state.images[view].empty())
            fits = state.images[view].half[0].width == width && state.images[view].half[0].height == height;
        if (!state.pixelShares.empty())
            fits = fits && (state.pixelShares[view].empty() || state.pixelShares[view].size() == std::size_t(width) * std::size_t(height));
    }
    if (!fits)
        throw Error(ErrorKind::Input, "what was kept of the run has other parameters", "their number, their sizes or the optimiser changed");
}

void Optimization::restore(OptimizeState state, const std::vector<std::vector<float>>& values, std::vector<std::vector<double>> gradients) {
    requireFits(state, values, gradients);
    state_ = std::move(state);
    gradients_ = std::move(gradients);
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        scene_.parameters[parameters_[i]].values = values[i];
        model_.setParameter(parameters_[i], values[i]);
    }
}

} // namespace cmpg

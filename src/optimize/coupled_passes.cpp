// Maps of one material that an optimisation steps together: which these are, what its curvature passes tell of them, and their steps.
#include "optimize/entry_loops.h"
#include "optimize/optimize.h"
#include "optimize/tangent_plane.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cmpg {
namespace {

// One texel of one is where one of the other is.
bool shareTexels(const Parameter& a, const Parameter& b) {
    return a.width == b.width && a.height == b.height && a.wrapU == b.wrapU && a.wrapV == b.wrapV && a.texcoord == b.texcoord && a.uvTransform == b.uvTransform;
}

} // namespace

// Light is left out, whose curvature is measured along its values.
void Optimization::findCoupled() {
    constexpr std::size_t kMostCoupled = std::size_t(1) << 22; // of a map: beyond, the blocks of three would take 0.8 GB
    std::vector<bool> taken(parameters_.size());
    const auto isOf = [&](const Material& material, std::size_t i) {
        const Parameter& parameter = scene_.parameters[parameters_[i]];
        return !emitsLight(parameter.kind) && material.parameters[std::size_t(parameter.kind)] == parameters_[i] && usesDiagonal(i) && !taken[i] &&
               std::size_t(parameter.width) * parameter.height <= kMostCoupled;
    };
    for (const Material& material : scene_.materials)
        for (std::size_t first = 0; first < parameters_.size(); ++first) {
            if (!isOf(material, first))
                continue;
            std::vector<std::size_t> maps;
            std::size_t block = 0;
            for (std::size_t i = first; i < parameters_.size(); ++i) {
                const Parameter& parameter = scene_.parameters[parameters_[i]];
                if (isOf(material, i) && shareTexels(scene_.parameters[parameters_[first]], parameter) && coarserBy(i) == coarserBy(first) && block + parameter.channels <= BlockCurvature::kMostEntries) {
                    maps.push_back(i);
                    block += parameter.channels;
                }
            }
            if (maps.size() < 2)
                continue;
            for (const std::size_t i : maps)
                taken[i] = true;
            coupled_.push_back(std::move(maps));
        }
}

std::size_t Optimization::coarserBy(std::size_t i) const { return coarse(i) ? coarse(i)->factor() : 1; }

const std::vector<std::size_t>* Optimization::coupledWith(std::size_t i) const {
    for (const std::vector<std::size_t>& maps : coupled_)
        if (std::find(maps.begin(), maps.end(), i) != maps.end())
            return &maps;
    return nullptr;
}

std::size_t Optimization::groupsOf(const std::vector<std::size_t>& maps) const {
    return maps.size() + std::size_t(std::count_if(maps.begin(), maps.end(), [&](std::size_t i) { return isNormal(i); })); // one for each axis
}

std::size_t Optimization::placeInBlock(const std::vector<std::size_t>& maps, std::size_t i) const {
    std::size_t place = 0;
    for (const std::size_t map : maps) {
        if (map == i)
            break;
        place += scene_.parameters[parameters_[map]].channels;
    }
    return place;
}

std::size_t Optimization::crossEntries(const std::vector<std::size_t>& maps) const {
    const Parameter& last = scene_.parameters[parameters_[maps.back()]];
    return std::size_t(last.width) * last.height * CrossCurvature::count(placeInBlock(maps, maps.back()) + last.channels);
}

void Optimization::addCross(std::size_t i, const CurvatureGroup& moved, std::span<const double> derivatives, double times) {
    const std::vector<std::size_t>& maps = *coupledWith(i);
    const auto found = std::find_if(maps.begin(), maps.end(), [&](std::size_t map) {
        return std::find(moved.parameters.begin(), moved.parameters.end(), map) != moved.parameters.end();
    });
    if (found == maps.end() || (*found == i && !isNormal(i)))
        return;
    const std::size_t other = *found, channels = scene_.parameters[parameters_[i]].channels, row = placeInBlock(maps, i);
    // The channels of a colour are moved together: each channel of the image tells of one. Where all of the image depends on an entry, they have become a sum.
    const auto isColour = [&](std::size_t map) { return scene_.parameters[parameters_[map]].channels == 3 && !isNormal(map); };
    if (isColour(other) && !isColour(i))
        return;
    const bool twice = isColour(i) == isColour(other); // the other way round as well
    const double part = times * (twice ? 0.5 : 1) / double(curvatureDirection(other)[0]);
    std::vector<float>& below = cross_[std::size_t(&maps - coupled_.data())].below;
    below.resize(crossEntries(maps));
    const std::size_t texels = derivatives.size() / channels, count = below.size() / texels, first = placeInBlock(maps, other) + moved.axis;
    forEachEntry(texels, [&](std::size_t texel) {
        for (std::size_t c = 0; c < channels; ++c) {
            const std::size_t at = row + c, column = first + (isColour(other) ? c : 0);
            const auto value = float(part * derivatives[texel * channels + c]);
            if (at != column && std::isfinite(value))
                below[texel * count + CrossCurvature::place(std::max(at, column), std::min(at, column))] += value;
        }
    });
}

// As addDiagonal() adds what stands on the diagonals.
void Optimization::addCrossCurvature() {
    for (std::size_t place = 0; place < cross_.size(); ++place) {
        const Moments& moments = state_.moments[coupled_[place][0]];
        std::vector<float>&known = state_.cross[place].below, &found = cross_[place].below;
        if (found.empty())
            continue;
        if (known.empty()) {
            known = std::move(found);
            continue;
        }
        const bool all = moments.peak.empty();
        const float again = viewOrder().wholeOrders(moments.start, state_.step) > 0 ? float(1 - viewShare_) : 1.f;
        const float kept = all ? 0.5f : again, taken = all ? 0.5f : 1.f;
        forEachEntry(known.size(), [&](std::size_t i) { known[i] = kept * known[i] + taken * found[i]; });
    }
    cross_.clear();
}

std::uint64_t Optimization::moveCoupled(std::size_t place, double factor, double residual) {
    const std::vector<std::size_t>& coupled = coupled_[place];
    std::vector<Parameter> steps; // of normals, with their gradients
    std::vector<std::vector<double>> gradients;
    steps.reserve(coupled.size());
    gradients.reserve(coupled.size());
    std::vector<CoupledMap> maps;
    for (const std::size_t i : coupled) {
        Parameter* moved = &scene_.parameters[parameters_[i]];
        std::span<const double> gradient = gradients_[i];
        if (isNormal(i)) {
            toSteps(moved->values, gradients.emplace_back(gradients_[i]));
            toSteps(moved->values, noise_[i]);
            gradient = gradients.back();
            moved = &steps.emplace_back(*moved);
            std::fill(moved->values.begin(), moved->values.end(), 0.f);
        }
        const double rate = slotRate(config_.optimizer, moved->kind) * factor * state_.moments[i].unit;
        maps.push_back({*moved, state_.moments[i], known_[i], gradient, noise_[i], rate, isNormal(i) ? std::numeric_limits<float>::lowest() : raisedFloorOf(parameters_[i])});
    }
    const std::uint64_t skipped = updateCoupled(maps, state_.cross[place], residual, viewShare_, coarserBy(coupled[0]));
    for (std::size_t m = 0; m < maps.size(); ++m)
        if (isNormal(coupled[m]))
            moveNormals(maps[m].parameter.values, scene_.parameters[parameters_[coupled[m]]].values);
    return skipped;
}

} // namespace cmpg

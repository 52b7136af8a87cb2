// The passes of an optimisation that measure the curvature of its loss, and the steps of constants by it.
#include "optimize/curvature_passes.h"

#include "base/stopwatch.h"
#include "optimize/entry_loops.h"
#include "optimize/gauss_newton.h"
#include "optimize/loaded_target.h"
#include "optimize/noise_weights.h"
#include "optimize/optimize.h"
#include "optimize/tangent_plane.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace cmpg {
namespace {

// Twice the samples of a step that carries an image on: what a difference of images is off by stays in the curvature for long.
constexpr std::uint32_t kCurvatureSpp = 4;
// Camera rays of a view that are kept while its curvature is measured: 80 MiB.
constexpr std::size_t kMostFirstVertices = std::size_t(1) << 22;
constexpr float kCurvatureStep = 0.05f; // by which parameters change where the bound of the curvature is measured, in their units
constexpr double kConstantStep = 0.02; // by which a constant changes, in its unit: roughness is far from linear
constexpr double kShapeReach = 0.1;    // of a lobe's shape: as far as a measured curvature may hold
constexpr double kLightReach = 20;     // of light, times its value instead of its unit: images are linear in it, however far it is

// The first step, and then ever more rarely: the curvature changes with the parameters, and these change ever less. `growth`: of the time until the next.
constexpr std::uint32_t kGrowth = 4, kGrowthOfLight = 2;
bool measuresCurvature(std::uint32_t step, std::uint32_t growth = kGrowth) {
    std::uint64_t at = 8;
    while (at < step)
        at *= growth;
    return step == 0 || step == at;
}

// More of it makes no pixel darker.
bool onlyBrightens(SlotKind kind) { return kind == SlotKind::BaseColor || kind == SlotKind::Emission || kind == SlotKind::Radiance; }

// Entries of a constant that are moved together, for one image of how the views change.
std::size_t entriesOfColumn(const Parameter& parameter) { return mixesChannels(parameter.kind) ? 1 : parameter.entries(); }

// Where the target is clipped and the image is brighter, the loss does not answer to the image, nor to what changes it.
void dropBeyondBounds(ImageHalves& halves, const Target& target) {
    const Image &a = halves.half[0].image, &b = halves.half[1].image;
    for (std::size_t k = 0; k < target.clipped.size(); ++k)
        if (target.clipped[k] && isBeyondBound(a.values[k], b.values[k], target.image.values[k]))
            halves.half[0].difference.values[k] = halves.half[1].difference.values[k] = 0;
}

// Without values, of a grid between whose texels all is interpolated.
Parameter emptyTexture(const Parameter& like, const TextureGrid& grid) {
    Parameter texture;
    texture.kind = like.kind;
    texture.width = std::uint32_t(grid.width);
    texture.height = std::uint32_t(grid.height);
    texture.channels = like.channels;
    texture.wrapU = like.wrapU;
    texture.wrapV = like.wrapV;
    texture.texcoord = like.texcoord;
    texture.uvTransform = like.uvTransform;
    return texture;
}

} // namespace

// Pictures count down from the last number, images that are carried on up from the first: one of each for a view.
constexpr std::uint32_t kMostPictures = 1 << 16;

PassKey curvatureKey(std::uint64_t seed, std::uint32_t step) { return {seed, ~kMostPictures - step, kPrimalPass}; }

PassKey scanKey(std::uint64_t seed, std::uint32_t step) { return {seed, kMostPictures + step, kPrimalPass}; }

void Optimization::findConstants(bool allowed) {
    const OptimizerKind asked = config_.optimizer.kind;
    if (!allowed || (asked != OptimizerKind::Auto && asked != OptimizerKind::GaussNewton))
        return;
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        const Parameter& parameter = scene_.parameters[parameters_[i]];
        if (parameter.entries() == parameter.channels && (parameter.channels == 1 || parameter.channels == 3) && parameter.kind != SlotKind::Normal)
            constants_.push_back(i);
    }
    std::size_t pixels = 0;
    for (std::size_t view = 0; view < model_.views(); ++view)
        pixels = std::max(pixels, std::size_t(model_.size(view).first) * model_.size(view).second);
    std::size_t columns = 0;
    for (const std::size_t i : constants_)
        columns += scene_.parameters[parameters_[i]].entries() / entriesOfColumn(scene_.parameters[parameters_[i]]);
    if (constants_.size() > kMostConstants || columns * pixels > kMostConstantPixels)
        constants_.clear();
    for (const std::size_t i : constants_)
        methods_[i] = OptimizerKind::GaussNewton;
}

template <class Value> std::vector<double> Optimization::ofConstants(const Value& value) const {
    std::vector<double> all;
    for (const std::size_t i : constants_)
        for (std::size_t entry = 0; entry < scene_.parameters[parameters_[i]].entries(); ++entry)
            all.push_back(value(i, entry));
    return all;
}

std::vector<double> Optimization::constantUnits() const {
    return ofConstants([&](std::size_t i, std::size_t) { return double(state_.moments[i].unit); });
}

std::vector<float> Optimization::constantValues() const {
    const std::vector<double> values = ofConstants([&](std::size_t i, std::size_t entry) { return double(scene_.parameters[parameters_[i]].values[entry]); });
    return {values.begin(), values.end()};
}

// Over which the images are about linear in a constant.
std::vector<double> Optimization::constantRanges() const {
    constexpr double kRange = 0.15;               // of the unit or the value, whichever is larger
    constexpr double kRatio = 0.3, kLeast = 0.02; // of a lobe's shape: of its value, at least this
    return ofConstants([&](std::size_t i, std::size_t entry) {
        const Parameter& parameter = scene_.parameters[parameters_[i]];
        const double value = std::abs(double(parameter.values[entry]));
        return shapesLobe(parameter.kind) ? std::max(kRatio * value, kLeast) : kRange * std::max(double(state_.moments[i].unit), value);
    });
}

bool Optimization::measuresConstants() const {
    if (constants_.empty())
        return false;
    if (state_.constants.empty() || state_.constants.isOld(constantValues(), constantRanges()))
        return true;
    const std::uint32_t step = state_.step - state_.moments[constants_[0]].start;
    return measuresCurvature(step) || (std::has_single_bit(step) && state_.constants.isNoisy());
}

void Optimization::measureConstants(StepReport& report) {
    if (!measuresConstants())
        return;
    const ScopedTime time(report.secondsGradient);
    for (std::size_t i = 0; i < parameters_.size(); ++i)
        model_.setSecondValues(parameters_[i], scene_.parameters[parameters_[i]].values);
    const std::size_t views = model_.views(), entries = constantUnits().size();
    ConstantProducts products(entries);
    for (std::size_t view = 0; view < views; ++view) {
        const PassKey key = curvatureKey(config_.seed, std::uint32_t(state_.step * views + view)); // one for all: what differs is the parameter
        const LoadedTarget target(config_.targets[view]);
        std::vector<ConstantColumn> columns;
        PixelAnswers answers;
        for (const std::size_t i : constants_) {
            const Parameter& parameter = scene_.parameters[parameters_[i]];
            const double largest = *std::max_element(parameter.values.begin(), parameter.values.end());
            double step = kConstantStep * std::max(double(state_.moments[i].unit), largest);
            if (largest + step > parameter.highest())
                step = -step;
            const std::size_t together = entriesOfColumn(parameter);
            for (std::size_t first = 0; first < parameter.entries(); first += together) {
                std::vector<float> moved = parameter.values;
                for (std::size_t entry = first; entry < first + together; ++entry)
                    moved[entry] += float(step);
                model_.setSecondValues(parameters_[i], moved);
                ImageHalves halves = model_.renderHalves(view, kCurvatureSpp, key, true, {});
                model_.setSecondValues(parameters_[i], parameter.values);
                dropBeyondBounds(halves, *target);
                report.samples += 2 * std::uint64_t(halves.samples) * halves.half[0].image.pixels();
                answers.add(halves.half[0].difference, halves.half[1].difference, target->mask);
                // The difference is to the moved values.
                columns.push_back({{std::move(halves.half[0].difference), std::move(halves.half[1].difference)}, std::uint32_t(together), -step});
            }
        }
        Image weight = lossCurvature(config_.loss, target->image, target->mask);
        for (float& value : weight.values)
            value /= float(views);
        addProducts(columns, weight, products);
        if (!anyUsesDiagonal())
            shares_[view] = answers.shares(weight.width, weight.height);
    }
    constantCurvature_.add(products, constantValues(), constantRanges());
}

bool Optimization::anyUsesDiagonal() const {
    for (std::size_t i = 0; i < parameters_.size(); ++i)
        if (usesDiagonal(i))
            return true;
    return false;
}

// What some views a step and all views a step tell of the curvature is not alike: the mean over all bounds no single one, and before its first order ends the
// other lacks views. Where a recovery goes on with the other of both, it is measured anew.
void Optimization::restartCurvature() {
    const ViewOrder order = viewOrder();
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
        const Moments& moments = state_.moments[i];
        if (usesDiagonal(i) && moments.steps > 0 && state_.step != order.stepsBeforeAll() && order.seesAll(state_.step) != moments.peak.empty())
            forgetCurvature(i);
    }
    // What maps do together is not known of those that stepped apart.
    for (std::size_t place = 0; place < coupled_.size(); ++place)
        if (state_.cross[place].below.size() != crossEntries(coupled_[place])) {
            state_.cross[place] = {};
            for (const std::size_t i : coupled_[place])
                if (state_.moments[i].steps > 0)
                    forgetCurvature(i);
        }
}

void Optimization::forgetCurvature(std::size_t i) {
    Moments& moments = state_.moments[i];
    moments.start = state_.step;
    moments.products = 0;
    moments.second.assign(moments.second.size(), 0.f);
    moments.peak = {};
    moments.seen = nullptr;
    if (const std::vector<std::size_t>* maps = coupledWith(i))
        state_.cross[std::size_t(maps - coupled_.data())] = {};
}

// As above from the first step on that sees all views; before, instead of steps, by how often all were seen. Also in the rest of an order that it begins in: views
// that are seen twice by then make steps shorter until all are measured again.
bool Optimization::measuresDiagonal(std::size_t i) const {
    if (!usesDiagonal(i))
        return false;
    const ViewOrder order = viewOrder();
    const std::uint32_t start = state_.moments[i].start, growth = emitsLight(scene_.parameters[parameters_[i]].kind) ? kGrowthOfLight : kGrowth;
    if (!order.seesAll(state_.step))
        return measuresCurvature(order.wholeOrders(start, state_.step), growth);
    const std::uint32_t since = state_.step - std::max(start, order.stepsBeforeAll());
    // What maps do together changes with all of them, most of all at first.
    return measuresCurvature(since, growth) || (!coupled_.empty() && std::has_single_bit(since));
}

bool Optimization::measuresAnyDiagonal() const {
    for (std::size_t i = 0; i < parameters_.size(); ++i)
        if (measuresDiagonal(i))
            return true;
    return false;
}

// Those that one image difference moves together. More of what only brightens makes no pixel darker, so that no effects of it cancel; of other slots
// each stands alone: metallic may darken what roughness brightens, and their sum would tell of no curvature at all. So does each axis of normals.
std::vector<Optimization::CurvatureGroup> Optimization::curvatureGroups() const {
    std::map<SlotKind, std::vector<std::size_t>> groups;
    const auto groupOf = [&](std::size_t i) {
        const SlotKind kind = scene_.parameters[parameters_[i]].kind;
        return onlyBrightens(kind) ? SlotKind::BaseColor : kind;
    };
    for (std::size_t i = 0; i < parameters_.size(); ++i)
        if (usesDiagonal(i))
            groups[groupOf(i)].push_back(i);
    for (const std::size_t i : constants_) // with textures alone: constants have passes of their own
        if (const auto found = groups.find(groupOf(i)); onlyBrightens(scene_.parameters[parameters_[i]].kind) && found != groups.end())
            found->second.push_back(i);
    std::vector<CurvatureGroup> all;
    for (const auto& [kind, group] : groups) {
        all.push_back({group, 0});
        if (kind == SlotKind::Normal)
            all.push_back({group, 1});
    }
    return all;
}

void Optimization::measureCurvature(std::span<const std::size_t> views, StepReport& report) {
    if (!measuresAnyDiagonal())
        return;
    const ScopedTime time(report.secondsGradient);
    const std::vector<CurvatureGroup> groups = curvatureGroups();
    curvature_ = gradients_; // zeros
    seen_.assign(parameters_.size(), {});
    cross_.assign(coupled_.size(), {});
    if (views.size() < model_.views())
        peak_ = gradients_;
    constantCurvature_.others.assign(constantCurvature_.others.size(), 0.0);
    std::vector<PixelAnswers> answers(model_.views());
    for (const CurvatureGroup& group : groups)
        measureGroup(group, groups.size(), views, answers, report);
    for (const std::size_t view : views) {
        const auto [width, height] = model_.size(view);
        shares_[view] = answers[view].shares(width, height);
    }
}

// `groups`: how many there are, n; maps that step together are one of them. The Hessian is at most n times its blocks of single groups, whatever their signs: (a + b)^2 <= 2 a^2 + 2 b^2. Steps
// descend by any bound of more than half of that, such as (n + 1) / 2 times, which is the block itself where n is 1. Where steps see some of the views the whole
// bound stays: that of a view that has not had its turn is out of date.
void Optimization::measureGroup(const CurvatureGroup& moving, std::size_t groups, std::span<const std::size_t> views,
                                std::vector<PixelAnswers>& answers, StepReport& report) {
    const std::vector<std::size_t>& group = moving.parameters;
    const auto isMoved = [&](std::size_t i) { return std::find(group.begin(), group.end(), i) != group.end(); };
    for (std::size_t i = 0; i < parameters_.size(); ++i)
        model_.setSecondValues(parameters_[i], isMoved(i) ? movedValues(i, moving.axis) : scene_.parameters[parameters_[i]].values);
    const bool all = views.size() == model_.views();
    std::vector<std::vector<double>> own; // of a view and the group
    if (!all || groups > 1)
        for (const std::vector<double>& gradient : gradients_)
            own.emplace_back(gradient.size(), 0.0);
    for (const std::size_t view : views) {
        const PassKey key = curvatureKey(config_.seed, std::uint32_t(state_.step * model_.views() + view)); // one for all groups: what differs is the parameter
        const LoadedTarget target(config_.targets[view]);
        ImageHalves halves = model_.renderHalves(view, kCurvatureSpp, key, true, {});
        dropBeyondBounds(halves, *target);
        const Image &a = halves.half[0].difference, &b = halves.half[1].difference;
        answers[view].add(a, b, target->mask);
        Image weight = lossCurvature(config_.loss, target->image, target->mask);
        if (weighsByNoise() && view < state_.images.size() && !state_.images[view].empty()) // as the last step weighed its gradient
            weigh(weight, noiseWeights(config_.loss, state_.images[view].half, *target, state_.losses[view].value));
        // The adjoint of a squared loss whose image is so much beside its target.
        Image adjoint = weight;
        for (std::size_t k = 0; k < adjoint.values.size(); ++k) {
            const float beside = -0.5f * (a.values[k] + b.values[k]);
            adjoint.values[k] = std::isfinite(beside) ? adjoint.values[k] * beside / float(all ? views.size() : 1) : 0.f;
        }
        report.samples += 2 * std::uint64_t(halves.samples) * adjoint.pixels();
        FirstVertices first;
        // Of several groups, whose texels answer for each other, C of each alone made steps end farther.
        const bool asks = groups == 1 && std::any_of(group.begin(), group.end(), [&](std::size_t i) { return seesTexels(i); }) &&
                          adjoint.pixels() * perPixel(config_.sppGradient) <= kMostFirstVertices;
        report.samples += model_.reverseApart(view, perPixel(config_.sppGradient), {key.seed, key.step, kGradientPass}, adjoint, own.empty() ? curvature_ : own, asks ? &first : nullptr);
        if (!first.vertices.empty())
            addSeenTexels(group, first, a, b, weight, noiseOf(config_.loss, {halves.half[0].image, halves.half[1].image}, *target).around);
        for (std::size_t i = 0; i < own.size(); ++i) {
            const std::vector<std::size_t>* const maps = coupledWith(i);
            if (isNormal(i) && (maps || isMoved(i)))
                toSteps(scene_.parameters[parameters_[i]].values, own[i]);
            if (maps)
                addCross(i, moving, own[i], 1 / double(all ? 1 : model_.views()));
            if (isNormal(i) && isMoved(i))
                dropOtherAxis(moving.axis, own[i]);
            const std::size_t apart = maps ? groups + 1 - groupsOf(*maps) : groups; // what the maps do together is known
            const double bound = all ? 0.5 * double(apart + 1) : double(apart);
            const double times = isConstant(i) ? 1 : isMoved(i) ? bound : 0;
            forEachEntry(own[i].size(), [&](std::size_t entry) {
                const double product = times * std::exchange(own[i][entry], 0);
                curvature_[i][entry] += product / double(all ? 1 : model_.views());
                if (!all)
                    peak_[i][entry] = std::max(peak_[i][entry], product);
            });
        }
    }
    if (constants_.empty())
        return;
    std::vector<double> unit = constantUnits();
    for (double& u : unit)
        u *= kCurvatureStep;
    const auto direction = [&](std::size_t i, std::size_t) { return isMoved(i) ? double(kCurvatureStep) * state_.moments[i].unit : 0.0; };
    const auto product = [&](std::size_t i, std::size_t entry) { return std::exchange(curvature_[i][entry], 0); };
    constantCurvature_.addOthers(ofConstants(product), ofConstants(direction), unit);
}

// Light is left out: its curvature is measured along its values (CurvatureDirection), of which a bright one would stand for its pixel. And the shape of lobes:
// what a pixel answers to a change of it holds for so short a way that steps by the diagonal, which average, end nearer. Where the first steps see views in turns,
// the texture is near when all are seen, and the diagonal follows noise less.
bool Optimization::seesTexels(std::size_t i) const {
    const SlotKind kind = scene_.parameters[parameters_[i]].kind;
    return usesDiagonal(i) && !emitsLight(kind) && !shapesLobe(kind) && viewOrder().stepsBeforeAll() == 0;
}

void Optimization::addSeenTexels(const std::vector<std::size_t>& group, const FirstVertices& first, const Image& a, const Image& b, const Image& weight,
                                 std::span<const float> noise) {
    const double part = 1 / double(model_.views()); // of the view, in the mean loss
    for (const std::size_t i : group) {
        if (!seesTexels(i))
            continue;
        const Parameter& parameter = scene_.parameters[parameters_[i]];
        std::vector<bool> owners;
        for (const Material& material : scene_.materials)
            owners.push_back(material.parameters[std::size_t(parameter.kind)] == parameters_[i]);
        Image curvature = weight;
        const double step = curvatureDirection(i).step;
        for (std::size_t k = 0; k < curvature.values.size(); ++k)
            curvature.values[k] *= float(part * double(a.values[k]) * b.values[k] / (step * step));
        if (const CoarseTexture* grid = coarse(i))
            seen_[i].add(emptyTexture(parameter, grid->coarse()), owners, first, curvature, noise);
        else
            seen_[i].add(parameter, owners, first, curvature, noise);
    }
}

std::vector<float> Optimization::movedValues(std::size_t i, std::size_t axis) const {
    std::vector<float> moved = scene_.parameters[parameters_[i]].values;
    const CurvatureDirection direction = curvatureDirection(i);
    if (isNormal(i)) {
        std::vector<float> steps(moved.size());
        for (std::size_t entry = axis; entry < steps.size(); entry += 3)
            steps[entry] = direction[entry];
        moveNormals(steps, moved);
    } else {
        for (std::size_t entry = 0; entry < moved.size(); ++entry)
            moved[entry] += direction[entry];
    }
    return moved;
}

CurvatureDirection Optimization::curvatureDirection(std::size_t i) const {
    const Parameter& parameter = scene_.parameters[parameters_[i]];
    CurvatureDirection direction{kCurvatureStep * state_.moments[i].unit};
    if (usesDiagonal(i) && emitsLight(parameter.kind)) {
        direction.light = parameter.values;
        direction.share = kCurvatureStep;
    }
    return direction;
}

void Optimization::addDiagonal(std::size_t i) {
    Moments& moments = state_.moments[i];
    const CurvatureDirection direction = curvatureDirection(i);
    moments.seen = nullptr;
    if (!seen_[i].empty()) {
        seen_[i].finish();
        moments.seen = std::make_shared<const SeenTexels>(std::move(seen_[i]));
    }
    if (peak_.empty())
        addCurvature(curvature_[i], direction, moments);
    else if (measuresDiagonal(i))
        addCurvature(curvature_[i], peak_[i], direction, viewOrder().wholeOrders(moments.start, state_.step) > 0 ? viewShare_ : 0, moments);
}

void Optimization::stepConstants(double factor) {
    if (constants_.empty())
        return;
    const auto value = [&](std::size_t i, std::size_t entry) { return double(scene_.parameters[parameters_[i]].values[entry]); };
    const auto reach = [&](std::size_t i, std::size_t entry) {
        const Parameter& parameter = scene_.parameters[parameters_[i]];
        const double unit = state_.moments[i].unit, length = emitsLight(parameter.kind) ? std::max(unit, kLightReach * value(i, entry)) : unit;
        const double far = std::min(kNewtonReach * slotRate(config_.optimizer, parameter.kind) * factor * length, 1e30);
        return shapesLobe(parameter.kind) ? std::min(far, kShapeReach) : far;
    };
    const auto rate = [&](std::size_t i, std::size_t) {
        const Parameter& parameter = scene_.parameters[parameters_[i]];
        return shapesLobe(parameter.kind) ? slotRate(config_.optimizer, parameter.kind) * factor * double(state_.moments[i].unit) : 0.0;
    };
    const auto down = [&](std::size_t i, std::size_t entry) {
        return std::max(-reach(i, entry), double(scene_.parameters[parameters_[i]].lowest()) - value(i, entry));
    };
    const auto up = [&](std::size_t i, std::size_t entry) {
        return std::min(reach(i, entry), double(std::min(scene_.parameters[parameters_[i]].highest(), kLargestValue)) - value(i, entry));
    };
    const auto gradient = [&](std::size_t i, std::size_t entry) { return gradients_[i][entry]; };
    const auto half = [&](std::size_t i, std::size_t entry) { return noise_[i][entry]; };
    Moments& shared = state_.moments[constants_[0]];
    // Of a lobe's shape alone, which a few bright pixels tell of: the light of a lamp that is clipped, whose curvature is hidden as well, went 8 % too far.
    std::vector<double> slope = ofConstants(gradient), noise = ofConstants(half);
    const std::vector<double> shapes = ofConstants([&](std::size_t i, std::size_t) { return double(shapesLobe(scene_.parameters[parameters_[i]].kind)); });
    state_.carried.advance(state_.constants, constantValues(), constantRanges(), slope, noise);
    for (std::size_t i = 0; i < noise.size(); ++i)
        if (shapes[i] > 0) {
            slope[i] = state_.carried.mean[i];
            noise[i] = std::copysign(std::sqrt(state_.carried.variance[i]), noise[i]);
        }
    const std::vector<double> step = constantStep(state_.constants, slope, noise, ofConstants(down), ofConstants(up), ofConstants(rate), shared);
    std::size_t at = 0;
    for (const std::size_t i : constants_) {
        Parameter& parameter = scene_.parameters[parameters_[i]];
        for (float& v : parameter.values)
            v = std::clamp(float(v + step[at++]), parameter.lowest(), std::min(parameter.highest(), kLargestValue));
        Moments& moments = state_.moments[i];
        std::tie(moments.noise, moments.steps) = std::tuple(shared.noise, shared.steps);
    }
}

} // namespace cmpg

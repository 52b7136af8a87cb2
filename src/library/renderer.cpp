// Renderers of the library's surface: passes over a copy of the scene that follows its values.
#include <cmpg/renderer.h>

#include "base/error.h"
#include "library/states.h"
#include "render/guided_passes.h"
#include "scene/image_size.h"

#include <algorithm>
#include <optional>

namespace cmpg::v1 {
namespace {

using Mode = cmpg::Renderer::Mode;
using Gradients = std::vector<std::vector<double>>;

void requireValid(const PassOptions& pass) {
    constexpr int kMostEdge = 1 << 15;
    require(pass.spp >= 1 && pass.spp <= kMostSamples, "spp", "from 1 to 16777216");
    require(pass.trainSpp <= kMostSamples, "train-spp", "at most 16777216");
    require(pass.train <= 100000, "train", "at most 100000 passes");
    require(pass.width >= 0 && pass.width <= kMostEdge, "width", "from 1 to 32768, or 0");
    require(pass.height >= 0 && pass.height <= kMostEdge, "height", "from 1 to 32768, or 0");
    if (pass.frozen && pass.train > 0)
        throw Error(ErrorKind::Usage, "a frozen pass draws from no guide", "its random numbers are those of an image without one",
                    "leave learning passes away", {"train"});
}

std::optional<std::uint32_t> given(int edge) { return edge > 0 ? std::optional(std::uint32_t(edge)) : std::nullopt; }

} // namespace

struct Renderer::State {
    std::shared_ptr<Device::State> device;
    std::shared_ptr<Scene::State> source;
    RendererOptions options;
    std::vector<std::uint32_t> parameters;
    std::vector<std::uint64_t> revisions; // of the source's parameters, as they are in `scene`
    cmpg::Scene scene;
    std::function<void()> call;
    std::unique_ptr<cmpg::Renderer> renderer; // null: to be made
    std::unique_ptr<GuidedPasses> passes;
    bool guided = false; // the renderer has a guide

    State(std::shared_ptr<Device::State> d, std::shared_ptr<Scene::State> s, const RendererOptions& o)
        : device(std::move(d)), source(std::move(s)), options(o), scene(copyOf(*source, o.parameters, parameters, revisions)) {
        renderConfig(options.paths, scene, parameters); // throws
    }
    ~State() {
        const std::lock_guard lock(device->mutex);
        drop();
    }
    State(const State&) = delete;

    void drop() {
        passes.reset();
        renderer.reset();
        guided = false;
    }

    // For passes of a mode, with a guide that knows nothing if they `learn` first.
    void ensure(Mode mode, bool learn) {
        if (renderer && !learn)
            return;
        drop();
        const bool roulette = options.paths.roulette && mode == Mode::Reverse;
        RenderConfig config = renderConfig(options.paths, scene, parameters);
        guided = learn && (options.paths.sampling != Sampling::Bsdf || roulette);
        config.guiding = guided;
        config.roulette = guided && roulette;
        renderer = std::make_unique<cmpg::Renderer>(device->device, scene, config);
        passes = std::make_unique<GuidedPasses>(*renderer, GuidedOptions{.sampling = options.paths.sampling,
                                                                         .pixels = options.paths.pixelSampling,
                                                                         .positivize = options.paths.positivize,
                                                                         .roulette = roulette});
    }

    // Takes over what has changed in the source.
    void follow() {
        const std::lock_guard lock(source->mutex);
        for (std::uint32_t p = 0; p < revisions.size(); ++p) {
            if (revisions[p] == source->revisions[p])
                continue;
            revisions[p] = source->revisions[p];
            const bool differentiable = std::find(parameters.begin(), parameters.end(), p) != parameters.end();
            if (renderer && differentiable) {
                renderer->setParameter(p, source->scene.parameters[p].values);
            } else {
                drop(); // kernels are made for the values of the others
                scene.parameters[p] = source->scene.parameters[p];
            }
        }
    }

    View viewOf(const PassOptions& pass) const {
        View view;
        view.camera = &scene.camera(pass.camera);
        std::tie(view.width, view.height) = imageSize(*view.camera, given(pass.width), given(pass.height), 512);
        return view;
    }

    // Error(Numerical) if a substantial part of the contributions since then was left out.
    void requireFew(const RenderStatistics& before) const {
        const RenderStatistics& now = renderer->statistics();
        const auto lost = [](const RenderStatistics& statistics) {
            std::uint64_t sum = 0;
            for (const auto& [kind, count] : statistics.dropped)
                sum += count;
            return sum;
        };
        constexpr double kTolerable = 0.01; // of the paths; beyond it the result is no estimate of anything
        if (double(lost(now) - lost(before)) > kTolerable * double(now.paths - before.paths))
            throw Error(ErrorKind::Numerical, "more than one path in a hundred was dropped", "values of the scene are so large or small that floats overflow",
                        "look for extreme emission, intensities or sizes in the scene");
    }

    // Runs a pass of a mode, after its learning passes.
    template <class Train, class Run> auto pass(Mode mode, const PassOptions& how, Train&& train, Run&& run) {
        const std::lock_guard lock(device->mutex);
        follow();
        ensure(mode, how.train > 0);
        renderer->setInteraction(interactionOf(call));
        const RenderStatistics before = renderer->statistics();
        try {
            if (guided && how.train > 0)
                train(how.trainSpp > 0 ? how.trainSpp : how.spp);
            auto result = run();
            requireFew(before);
            return result;
        } catch (...) {
            if (guided) // it may be half of what was asked for
                drop();
            throw;
        }
    }
};

Renderer::Renderer(const Device& device, const Scene& scene, const RendererOptions& options)
    : state_(std::make_shared<State>(device.state(), scene.state(), options)) {}

Image Renderer::render(const PassOptions& pass) {
    requireValid(pass);
    State& s = *state_;
    const View view = s.viewOf(pass);
    return s.pass(
        Mode::Render, pass, [&](std::uint32_t spp) { s.passes->trainRender(view, spp, pass.train, pass.seed); },
        [&] {
            if (!pass.frozen)
                return s.passes->render(view, pass.spp, {.seed = pass.seed});
            return s.renderer->render(view, pass.spp, {.seed = pass.seed});
        });
}

Image Renderer::forward(std::span<const Direction> directions, const PassOptions& pass) {
    requireValid(pass);
    State& s = *state_;
    const View view = s.viewOf(pass);
    std::vector<std::uint32_t> parameters;
    std::vector<std::vector<float>> values;
    for (const Direction& direction : directions) {
        const std::uint32_t index = s.scene.parameter(direction.parameter);
        if (std::find(s.parameters.begin(), s.parameters.end(), index) == s.parameters.end())
            throw Error(ErrorKind::Usage, direction.parameter + " was not named when the renderer was made",
                        "kernels are made for the parameters that were", "name it there", {"param"});
        if (direction.values.size() != s.scene.parameters[index].entries())
            throw Error(ErrorKind::Usage,
                        "the direction of " + direction.parameter + " has " + std::to_string(direction.values.size()) + " values, not " +
                            std::to_string(s.scene.parameters[index].entries()),
                        {}, "give one for every entry of the parameter");
        parameters.push_back(index);
        values.push_back(direction.values);
    }
    if (parameters.empty())
        throw Error(ErrorKind::Usage, "a derivative needs a direction", {}, "name a parameter and give its direction", {"param"});
    return s.pass(
        Mode::Forward, pass, [&](std::uint32_t spp) { s.passes->trainForward(view, spp, pass.train, pass.seed, parameters, values); },
        [&] {
            if (!pass.frozen)
                return s.passes->forward(view, pass.spp, {.seed = pass.seed, .pass = 1}, parameters, values);
            return s.renderer->forward(view, pass.spp, {.seed = pass.seed}, parameters, values);
        });
}

Gradients Renderer::backward(const Image& adjoint, const PassOptions& pass) {
    requireValid(pass);
    State& s = *state_;
    if (s.parameters.empty())
        throw Error(ErrorKind::Usage, "no parameter was named when the renderer was made", {}, "name what derivatives are asked for", {"param"});
    if (adjoint.channels != 3 || adjoint.width < 1 || adjoint.height < 1 || adjoint.values.size() != adjoint.pixels() * 3)
        throw Error(ErrorKind::Usage, "the adjoint is no image of 3 channels", {}, "give the derivative of a scalar by every pixel and channel");
    if ((pass.width > 0 && pass.width != adjoint.width) || (pass.height > 0 && pass.height != adjoint.height))
        throw Error(ErrorKind::Usage,
                    "the adjoint is " + std::to_string(adjoint.width) + "x" + std::to_string(adjoint.height) + ", not of the pass's size", {},
                    "leave the size away", {"width", "height"});
    PassOptions sized = pass;
    sized.width = adjoint.width;
    sized.height = adjoint.height;
    const View view = s.viewOf(sized);
    return s.pass(
        Mode::Reverse, pass, [&](std::uint32_t spp) { s.passes->trainReverse(view, spp, pass.train, pass.seed, adjoint); },
        [&] {
            Gradients gradients;
            for (const std::uint32_t p : s.parameters)
                gradients.emplace_back(s.scene.parameters[p].entries());
            if (pass.frozen) {
                s.renderer->reverse(view, pass.spp, {.seed = pass.seed}, adjoint, {}, {}, gradients);
            } else {
                s.passes->reverse(view, pass.spp, {.seed = pass.seed, .pass = 1}, adjoint, gradients);
            }
            return gradients;
        });
}

std::vector<ParameterInfo> Renderer::parameters() const {
    std::vector<ParameterInfo> infos;
    for (const std::uint32_t p : state_->parameters)
        infos.push_back(describe(state_->scene.parameters[p]));
    return infos;
}

void Renderer::onSubmission(std::function<void()> call) {
    const std::lock_guard lock(state_->device->mutex);
    state_->call = std::move(call);
}

} // namespace cmpg::v1

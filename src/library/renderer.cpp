// Renderers of the library's surface: passes, their learning and their budgets.
#include <cmpg/renderer.h>

#include "base/error.h"
#include "library/guide_point.h"
#include "library/renderer_state.h"
#include "optimize/gradient_check.h"
#include "render/saved_guide.h"
#include "scene/parameter_values.h"

#include <algorithm>
#include <cmath>

namespace cmpg::v1 {
namespace {

using Mode = cmpg::Renderer::Mode;
using Gradients = std::vector<std::vector<double>>;

// Adds `spp` samples to a film by pass(samples), in growing parts of at most about half a second, and shows it after each. The film is what
// one pass would have made.
template <class Pass> void grow(cmpg::Film& film, std::uint32_t spp, const std::function<void(const Image&)>& show, Pass&& pass) {
    constexpr double kLong = 0.5;
    std::uint32_t part = 1;
    while (film.samples < spp) {
        const Stopwatch watch;
        part = std::min(part, spp - film.samples);
        pass(part);
        show(film.image());
        if (watch.seconds() < kLong / 2)
            part *= 2;
    }
}

// An image as the options ask for. `all`: one pass with its layers; `more`: further samples of a film.
// `grows`: not on several ranks, whose clocks would divide it differently.
template <class All, class More>
Image imageOf(const PassOptions& pass, const View& view, std::uint32_t spp, Layers& layers, bool grows, All&& all, More&& more) {
    if (pass.onImage && grows) {
        cmpg::Film film(view.width, view.height, pass.layers);
        grow(film, spp, pass.onImage, [&](std::uint32_t samples) { more(samples, film); });
        if (pass.layers)
            layers = film.layers();
        return film.image();
    }
    Image image = all(pass.layers ? &layers : nullptr);
    if (pass.onImage)
        pass.onImage(image);
    return image;
}

void requireNoLayers(const PassOptions& pass, const std::string& what) {
    if (pass.layers)
        throw Error(ErrorKind::Usage, what, {}, "leave layers away", {"layers"});
}

// A pass of a film: of its size, and without what only whole images have.
PassOptions passOf(const Film& film, const PassOptions& pass) {
    if ((pass.width > 0 && pass.width != film.width()) || (pass.height > 0 && pass.height != film.height()))
        throw Error(ErrorKind::Usage,
                    "the film is " + std::to_string(film.width()) + "x" + std::to_string(film.height()) + ", not of the pass's size", {}, "leave the size away",
                    {"width", "height"});
    require(film.width() > 0, "width", "that of a film with pixels");
    if (pass.train > 0 || pass.frozen || batchesOf(pass) > 0)
        throw Error(ErrorKind::Usage, "a film takes no learning passes, batches or frozen passes", {}, "leave them away: Renderer::train() learns",
                    {"train", "batches", "error-target", "time-budget"});
    PassOptions own = pass;
    own.width = film.width();
    own.height = film.height();
    own.layers = false;
    own.onImage = {};
    return own;
}

// A pass of an adjoint, of its size.
PassOptions passOf(const std::vector<std::uint32_t>& parameters, const Image& adjoint, const PassOptions& pass) {
    requireNoLayers(pass, "layers belong to images");
    if (parameters.empty())
        throw Error(ErrorKind::Usage, "no parameter was named when the renderer was made", {}, "name what derivatives are asked for", {"param"});
    if (adjoint.channels != 3 || adjoint.width < 1 || adjoint.height < 1 || adjoint.values.size() != adjoint.pixels() * 3)
        throw Error(ErrorKind::Usage, "the adjoint is no image of 3 channels", {}, "give the derivative of a scalar by every pixel and channel");
    if (!std::all_of(adjoint.values.begin(), adjoint.values.end(), [](float value) { return std::isfinite(value); }))
        throw Error(ErrorKind::Usage, "the adjoint has values that are not finite", "the loss divides by 0 or overflows at some pixel",
                    "give 0 for pixels that are to be left out");
    if ((pass.width > 0 && pass.width != adjoint.width) || (pass.height > 0 && pass.height != adjoint.height))
        throw Error(ErrorKind::Usage,
                    "the adjoint is " + std::to_string(adjoint.width) + "x" + std::to_string(adjoint.height) + ", not of the pass's size", {},
                    "leave the size away", {"width", "height"});
    PassOptions sized = pass;
    sized.width = adjoint.width;
    sized.height = adjoint.height;
    sized.onImage = {};
    return sized;
}

// Learning passes alone.
PassOptions learningOf(const PassOptions& pass) {
    PassOptions own = pass;
    own.batches = 0;
    own.errorTarget = own.timeBudget = 0;
    own.layers = false;
    return own;
}

// What a pass sees, once its options are found to be right.
template <class Check> PassView viewOf(Renderer::State& state, const PassOptions& pass, Check&& check) {
    return checked(state.device->ranks(), [&] {
        requireValid(pass);
        check();
        return PassView(state.scene, pass);
    });
}
PassView viewOf(Renderer::State& state, const PassOptions& pass) {
    return viewOf(state, pass, [] {});
}

} // namespace

// What directions say, by index. Error(Usage) where there are none.
struct Renderer::State::Along {
    std::vector<std::uint32_t> parameters;
    std::vector<std::vector<float>> values;
    std::vector<const std::vector<float>*> input;

    Along(const State& state, std::span<const Direction> directions) {
        for (const Direction& direction : directions) {
            parameters.push_back(state.indexOf(direction));
            values.push_back(direction.values);
            input.push_back(&direction.values);
        }
        if (parameters.empty())
            throw Error(ErrorKind::Usage, "a derivative needs a direction", {}, "name a parameter and give its direction", {"param"});
    }
};

Renderer::State::Along Renderer::State::along(std::span<const Direction> directions) const {
    return checked(device->ranks(), [&] { return Along(*this, directions); });
}

Renderer::Renderer(const Device& device, const Scene& scene, const RendererOptions& options)
    : state_(makeState<State>(device.state(), scene.state(), options)) {}

Image Renderer::render(const PassOptions& pass, PassReport* report) {
    State& s = *state_;
    const State::Work work(s);
    const PassView seen = viewOf(s, pass);
    const View& view = seen.view();
    const PassKey key{.seed = pass.seed, .step = pass.frame};
    return s.pass(
        work, Mode::Render, view, pass, {}, report, [&](std::uint32_t spp) { s.passes->trainRender(view, spp, pass.train, pass.seed); },
        [&](std::uint32_t spp) {
            if (batchesOf(pass) > 0)
                return toImage(s.spend(pass, view, key, true,
                                       [&](std::uint32_t samples, const PassKey& part) { return fromImage(s.passes->render(view, samples, part)); }),
                               view.width, view.height);
            if (pass.frozen)
                return s.renderer->render(view, spp, key, {}, nullptr, pass.layers ? &s.told.layers : nullptr);
            return imageOf(
                pass, view, spp, s.told.layers, s.device->ranks().size() == 1, [&](Layers* layers) { return s.passes->render(view, spp, key, layers); },
                [&](std::uint32_t samples, cmpg::Film& film) { s.passes->render(view, samples, key, film); });
        });
}

Image Renderer::forward(std::span<const Direction> directions, const PassOptions& pass, PassReport* report) {
    State& s = *state_;
    const bool positivize = s.options.paths.positivize;
    const State::Work work(s);
    const PassView seen = viewOf(s, pass, [&] {
        if (positivize)
            requireNoLayers(pass, "the halves of positivised derivatives have mixtures of their own");
    });
    const View& view = seen.view();
    const PassKey frozen{.seed = pass.seed, .step = pass.frame}, key{.seed = pass.seed, .step = pass.frame, .pass = 1};
    const State::Along along = s.along(directions);
    const std::vector<std::uint32_t>& parameters = along.parameters;
    const std::vector<std::vector<float>>& values = along.values;
    return s.pass(
        work, Mode::Forward, view, pass, along.input, report,
        [&](std::uint32_t spp) { s.passes->trainForward(view, spp, pass.train, pass.seed, parameters, values); },
        [&](std::uint32_t spp) {
            if (batchesOf(pass) > 0)
                return toImage(s.spend(pass, view, key, !positivize,
                                       [&](std::uint32_t samples, const PassKey& part) {
                                           return fromImage(s.passes->forward(view, samples, part, parameters, values));
                                       }),
                               view.width, view.height);
            if (pass.frozen)
                return s.renderer->forward(view, spp, frozen, parameters, values, {}, nullptr, pass.layers ? &s.told.layers : nullptr);
            return imageOf(
                pass, view, spp, s.told.layers, !positivize && s.device->ranks().size() == 1, // halves grow no film
                [&](Layers* layers) { return s.passes->forward(view, spp, key, parameters, values, layers); },
                [&](std::uint32_t samples, cmpg::Film& film) { s.passes->forward(view, samples, key, parameters, values, film); });
        });
}

void Renderer::render(Film& film, const PassOptions& pass, PassReport* report) {
    State& s = *state_;
    const State::Work work(s);
    const PassOptions own = checked(s.device->ranks(), [&] { return passOf(film, pass); });
    const PassView seen = viewOf(s, own);
    s.expose(work, Mode::Render, film, seen.view(), own, {}, report, [&](std::uint32_t spp, cmpg::Film& sums) {
        s.passes->render(seen.view(), spp, {.seed = own.seed, .step = own.frame}, sums);
    });
}

void Renderer::forward(Film& film, std::span<const Direction> directions, const PassOptions& pass, PassReport* report) {
    State& s = *state_;
    const State::Work work(s);
    const PassOptions own = checked(s.device->ranks(), [&] { return passOf(film, pass); });
    const PassView seen = viewOf(s, own);
    const State::Along along = s.along(directions);
    s.expose(work, Mode::Forward, film, seen.view(), own, along.input, report, [&](std::uint32_t spp, cmpg::Film& sums) {
        s.passes->forward(seen.view(), spp, {.seed = own.seed, .step = own.frame, .pass = 1}, along.parameters, along.values, sums);
    });
}

void Renderer::train(const PassOptions& pass) {
    const PassOptions own = learningOf(pass);
    State& s = *state_;
    const State::Work work(s);
    const PassView seen = viewOf(s, own);
    s.train(work, Mode::Render, seen.view(), own, {},
            [&](std::uint32_t spp, std::uint32_t number) { s.passes->trainRender(seen.view(), spp, 1, own.seed, number); });
}

void Renderer::train(std::span<const Direction> directions, const PassOptions& pass) {
    const PassOptions own = learningOf(pass);
    State& s = *state_;
    const State::Work work(s);
    const PassView seen = viewOf(s, own);
    const State::Along along = s.along(directions);
    s.train(work, Mode::Forward, seen.view(), own, along.input, [&](std::uint32_t spp, std::uint32_t number) {
        s.passes->trainForward(seen.view(), spp, 1, own.seed, along.parameters, along.values, number);
    });
}

void Renderer::forget() {
    const State::Work work(*state_);
    if (state_->capacity)
        state_->drawAnew(false);
    else
        state_->drop();
}

void Renderer::setSampling(Sampling sampling) {
    State& s = *state_;
    const State::Work work(s);
    if (!s.capacity)
        throw Error(ErrorKind::Usage, "this renderer draws as it was made to", "it has no memory for other methods", "make it with RendererOptions::recoveries");
    s.options.paths.sampling = sampling;
    s.drawAnew(true);
}

Gradients Renderer::backward(const Image& adjoint, const PassOptions& pass, PassReport* report) {
    State& s = *state_;
    const State::Work work(s);
    const PassOptions sized = checked(s.device->ranks(), [&] { return passOf(s.parameters, adjoint, pass); });
    const PassView seen = viewOf(s, sized);
    const View& view = seen.view();
    const PassKey frozen{.seed = pass.seed, .step = pass.frame}, key{.seed = pass.seed, .step = pass.frame, .pass = 1};
    const bool continues = !s.options.paths.positivize && s.options.paths.pixelSampling == PixelSampling::Uniform;
    return s.pass(
        work, Mode::Reverse, view, sized, {&adjoint.values}, report, [&](std::uint32_t spp) { s.passes->trainReverse(view, spp, pass.train, pass.seed, adjoint); },
        [&](std::uint32_t spp) {
            Gradients gradients;
            for (const std::uint32_t p : s.parameters)
                gradients.emplace_back(s.scene.parameters[p].entries());
            if (batchesOf(pass) > 0)
                divide(s.spend(sized, view, key, continues,
                               [&](std::uint32_t samples, const PassKey& part) {
                                   Gradients found;
                                   s.passes->reverse(view, samples, part, adjoint, found);
                                   return joined(found);
                               }),
                       gradients);
            else if (pass.frozen)
                s.renderer->reverse(view, spp, frozen, adjoint, {}, {}, gradients);
            else
                s.passes->reverse(view, spp, key, adjoint, gradients);
            return gradients;
        });
}

CheckResult Renderer::check(const Direction& direction, const PassOptions& pass, std::uint32_t sppGradient, PassReport* report) {
    PassOptions how = pass;
    how.frozen = true; // draws from no guide
    how.spp = pass.spp > 0 ? pass.spp : 16;
    if (how.width == 0 && how.height == 0)
        how.width = 128; // many renders, compared by blocks
    State& s = *state_;
    const State::Work work(s);
    const PassView seen = viewOf(s, how, [&] {
        require(sppGradient <= kMostSamples, "spp-gradient", "from 1 to 16777216, or 0");
        requireNoLayers(pass, "a check makes no image");
    });
    const State::Along along = s.along(std::span(&direction, 1));
    const std::uint32_t index = along.parameters.front(), parameters[] = {index};
    const View& view = seen.view();
    return s.pass(work, Mode::Forward, view, how, {&direction.values}, report, [](std::uint32_t) {},
                  [&](std::uint32_t spp) {
                      const std::vector<std::vector<float>> directions{direction.values};
                      double seconds = 0;
                      CheckSubject subject;
                      subject.parameter = &s.scene.parameters[index];
                      subject.values = valuesOf(s.scene.parameters[index]);
                      subject.direction = direction.values;
                      subject.forward = [&](std::uint32_t repetition) {
                          const Stopwatch watch;
                          Image image = s.renderer->forward(view, sppGradient > 0 ? sppGradient : spp,
                                                            {.seed = pass.seed, .step = repetition, .pass = 1}, parameters, directions);
                          seconds += watch.seconds();
                          return image;
                      };
                      const std::unique_ptr<cmpg::Renderer> differing = s.makeDiffering();
                      subject.difference = [&](std::uint32_t repetition, std::span<const float> moved) {
                          const Stopwatch watch;
                          differing->setSecondValues(index, moved);
                          ImageDifference both = differing->renderDifference(view, spp, {.seed = pass.seed, .step = repetition});
                          s.told.imageSeconds += watch.seconds();
                          return both;
                      };
                      CheckResult result = checkGradient(subject);
                      s.told.seconds = seconds;
                      return result;
                  });
}

void Renderer::prepare(std::initializer_list<PassKind> kinds, const PassOptions& pass) {
    requireValid(pass);
    State& s = *state_;
    const auto has = [&](PassKind kind) { return std::find(kinds.begin(), kinds.end(), kind) != kinds.end(); };
    const State::Work work(s);
    s.ensure(has(PassKind::Backward) ? Mode::Reverse : has(PassKind::Forward) ? Mode::Forward : Mode::Render, pass.train > 0);
    for (const PassKind kind : kinds)
        s.renderer->expect({modeOf(kind)});
    for (const PassKind kind : kinds)
        s.renderer->prepare({modeOf(kind)}, pass.layers);
}

Footprint Renderer::footprint(const std::vector<PassKind>& kinds, const PassOptions& pass) {
    requireValid(pass);
    const State::Work work(*state_);
    return state_->footprint(kinds, pass.train > 0);
}

void Renderer::saveGuide(const std::filesystem::path& file) const {
    State& s = *state_;
    const std::lock_guard lock(s.device->mutex);
    if (!s.guided || (s.fresh && s.options.paths.guide.load.empty()))
        throw Error(ErrorKind::Usage, "there is no guide to save: none was learned", {}, "make a pass with learning passes before it", {"train"});
    if (s.device->ranks().isRoot())
        writeGuide(file, s.scene, s.parameters, *s.renderer, *s.passes);
}

std::vector<ParameterInfo> Renderer::parameters() const {
    std::vector<ParameterInfo> infos;
    for (const std::uint32_t p : state_->parameters)
        infos.push_back(describe(state_->scene.parameters[p]));
    return infos;
}

PassReport Renderer::report(PassKind kind) const {
    const std::lock_guard lock(state_->device->mutex);
    return state_->totals(modeOf(kind));
}

std::optional<GuidePoint> Renderer::guideAt(const std::array<float, 3>& position, PassKind kind) const {
    const State& s = *state_;
    const std::lock_guard lock(s.device->mutex);
    const SdTree* const guide = s.guide();
    if (!guide)
        return {};
    // Images have no derivatives: whatever guides them guides by light.
    const Sampling sampling = kind == PassKind::Render ? Sampling::Primal : s.passes->decision().method.kind;
    return guidePoint(*guide, {position[0], position[1], position[2]}, sampling, s.options.paths.guide.share);
}

std::optional<Image> Renderer::guideCells(const Image& depth, const PassOptions& pass) const {
    if (depth.channels != 1 || depth.width < 1 || depth.height < 1 || depth.values.size() != depth.pixels())
        throw Error(ErrorKind::Usage, "the depth is no image of one channel", {}, "give the depth of a pass's layers");
    PassOptions sized = pass;
    sized.width = depth.width;
    sized.height = depth.height;
    requireValid(sized);
    const State& s = *state_;
    const std::lock_guard lock(s.device->mutex);
    const SdTree* const guide = s.guide();
    if (!guide)
        return {};
    const PassView seen(s.scene, sized);
    return cellNumbers(*guide, CameraRays(*seen.view().camera, depth.width, depth.height), depth);
}

void Renderer::onSubmission(std::function<void()> call, double seconds) {
    require(seconds >= 0.001 && seconds <= 10, "seconds of a submission", "from 0.001 to 10");
    const std::lock_guard lock(state_->device->mutex);
    state_->call = std::move(call);
    state_->callSeconds = seconds;
}

void Renderer::onCompile(std::function<void(bool)> call) {
    const std::lock_guard lock(state_->device->mutex);
    state_->compiling = std::move(call);
}

} // namespace cmpg::v1

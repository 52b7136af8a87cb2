// Images, films, derivative images and gradients: what a renderer asks of its passes.
#include "render/renderer.h"

#include "base/error.h"
#include "render/gradient_sums.h"
#include "render/pass_runner.h"
#include "vk/spirv_size.h"

#include <algorithm>
#include <cmath>

namespace cmpg {

namespace {

using gpu::kModeDifference, gpu::kModeForward, gpu::kModeRender, gpu::kModeReverse;

constexpr std::uint32_t kPilotSize = 32; // edge of the pilot image that fixes the scale of the gradient sums

// Decoding 8-bit texels at every look-up costs more than reading floats; only large textures nobody changes stay packed.
constexpr std::size_t kPackedTexels = std::size_t(1) << 20;

Scene& unpackSmallTextures(Scene& scene) {
    for (Parameter& p : scene.parameters)
        if (std::size_t(p.width) * p.height < kPackedTexels)
            p.materialise();
    return scene;
}

} // namespace

struct Renderer::Impl {
    Device& device;
    Scene& scene;
    RenderConfig config;
    FeatureSet features;
    SceneBuffers buffers;
    std::optional<Guide> guide;
    PassRunner runner;

    Impl(Device& d, Scene& s, const RenderConfig& c)
        : device(d), scene(unpackSmallTextures(s)), config(c),
          // Nothing is scattered at the last segment, so with one no light is sampled.
          features(analyse(s, {c.differentiable, c.lightSampling && c.maxDepth > 1, c.guiding, c.allFeatures})),
          buffers(d, s, features, c.differentiable, c.frozenEvaluation || c.differences),
          guide(features.guiding ? std::optional<Guide>(std::in_place, d, s, config) : std::nullopt), runner(d, features, buffers, guide, config) {}

    // Whether the guide has anything to draw from.
    bool learned() const { return guide && !guide->tree.empty(); }

    FeatureSet::Pass passOf(std::uint32_t mode, bool layers, const PassPlan& plan) const { return runner.kernels.passOf(mode, layers, plan, learned()); }

    Image image(std::uint32_t mode, const View& view, std::uint32_t spp, const PassKey& key, const PassPlan& plan, PassResult* result, Layers* layers,
                Image* difference = nullptr, const SampleRanges& samples = {}) {
        PassInput in = passInput(view, key, spp);
        in.perPixel = samples.counts;
        in.firsts = samples.firsts;
        in.plan = plan;
        Image image(view.width, view.height, 3);
        double variance = 0; // of the pixels' means, summed
        if (layers)
            *layers = emptyLayers(view.width, view.height, spp, layerDepths());
        const PassRunner::Outcome outcome = runner.run(passOf(mode, layers != nullptr, plan), in, [&](std::size_t pixel, const Gathered& g) {
            const std::uint32_t count = in.samples(pixel);
            const glm::dvec4 means = filmSums(g.film) / double(count);
            for (int c = 0; c < 3; ++c)
                image.values[3 * pixel + c] = float(means[c]);
            if (difference)
                for (int c = 0; c < 3; ++c)
                    difference->values[3 * pixel + c] = meanOf(g.difference, count)[c];
            variance += std::max(0.0, means.w - glm::dot(glm::dvec3(means), glm::dvec3(means)) / 3) / double(std::max(1u, count - 1));
            if (layers)
                setLayers(*layers, pixel, g.layers);
        });
        if (result) {
            *result = outcome.result;
            result->variance = variance;
        }
        return image;
    }

    // That layers tell of: nothing is drawn at the last one.
    std::uint32_t layerDepths() const { return std::min(gpu::kLayerDepths, config.maxDepth - 1); }

    // Leaves no records.
    void addTo(Film& film, std::uint32_t mode, const View& view, std::uint32_t spp, const PassKey& key, const PassPlan& plan) {
        if (film.width != view.width || film.height != view.height)
            throw Error(ErrorKind::Usage, "the film's size differs from the view's");
        PassInput in = passInput(view, key, spp);
        in.plan = plan;
        in.plan.record = false;
        in.film = &film;
        Film sum(film.width, film.height, film.hasLayers());
        runner.run(passOf(mode, film.hasLayers(), in.plan), in, [&](std::size_t pixel, const Gathered& g) {
            sum.pixels[pixel] = g.film;
            if (sum.hasLayers())
                sum.layerSums[pixel] = g.layers;
        });
        sum.samples = film.samples + spp;
        sum.layerDepths = layerDepths();
        film = std::move(sum);
    }

    // Before the pools are filled for the pass: the pilot image may need other ones.
    void openRecords(const View& view, const PassKey& key, const PassPlan& plan, const FeatureSet::Pass& pilot) {
        if (guide && plan.record && plan.keepRecords)
            guide->openRecords([&] { return pilotRadiance(view, key, pilot); }, shortestNormal(scene, config.differentiable));
    }

    void uploadDirection(std::span<const std::uint32_t> parameters, std::span<const std::vector<float>> directions, const PassPlan& plan, bool layers) {
        runner.prepare(passOf(kModeForward, layers, plan)); // has the buffer made
        std::vector<float> direction(buffers.gradientEntries(), 0.0f);
        for (std::size_t i = 0; i < parameters.size(); ++i) {
            const auto found = std::find(config.differentiable.begin(), config.differentiable.end(), parameters[i]);
            if (found == config.differentiable.end())
                throw Error(ErrorKind::Usage, scene.parameters[parameters[i]].name + " was not named as differentiable");
            const std::uint64_t at = buffers.gradientOffset(std::size_t(found - config.differentiable.begin()));
            if (directions[i].size() != scene.parameters[parameters[i]].entries())
                throw Error(ErrorKind::Usage, "the direction of " + scene.parameters[parameters[i]].name + " has the wrong number of entries");
            std::copy(directions[i].begin(), directions[i].end(), direction.begin() + std::ptrdiff_t(at));
        }
        runner.pools().direction.uploadAll(direction);
    }

    // Mean radiance of a coarse image of the view, drawn without guide: the same whatever the batches, the budget or the driver. `pass`: whose
    // kernels run, those that are needed anyway.
    double pilotRadiance(const View& view, const PassKey& key, const FeatureSet::Pass& pass) {
        PassInput in;
        in.pilot = true;
        in.view = view;
        in.key = {key.seed, 0, 2};
        in.width = in.height = kPilotSize;
        in.spp = 1;
        double sum = 0;
        runner.run(pass, in, [&](std::size_t, const Gathered& g) {
            const glm::dvec3 value(filmSums(g.film));
            sum += (std::abs(value.x) + std::abs(value.y) + std::abs(value.z)) / 3;
        });
        const double mean = sum / (double(kPilotSize) * kPilotSize);
        return mean > 0 ? mean : 1.0;
    }
};

Renderer::Renderer(Device& device, Scene& scene, const RenderConfig& config) : impl_(std::make_unique<Impl>(device, scene, config)) {
    if (config.maxDepth < 1)
        throw Error(ErrorKind::Usage, "the depth must be at least 1", "depth counts path segments", "raise the depth", {"max-depth"});
}

Renderer::~Renderer() = default;

void Renderer::prepare(std::initializer_list<Mode> modes, bool layers) {
    expect(modes);
    for (const Mode m : modes)
        impl_->runner.prepare(impl_->runner.kernels.passOf(std::uint32_t(m), layers && m != Mode::Reverse, {}, false));
}

void Renderer::prepare(Mode mode, const PassPlan& plan, bool layers, bool learned) {
    impl_->runner.prepare(impl_->runner.kernels.passOf(std::uint32_t(mode), layers, plan, learned || impl_->learned()));
}

void Renderer::expect(std::initializer_list<Mode> modes) {
    for (const Mode m : modes)
        impl_->runner.kernels.expect(std::uint32_t(m));
}

void Renderer::prepareAhead(std::span<const std::pair<Mode, PassPlan>> passes) {
    std::vector<FeatureSet::Pass> kinds;
    for (const auto& [mode, plan] : passes)
        kinds.push_back(impl_->passOf(std::uint32_t(mode), false, plan));
    impl_->runner.kernels.prepareAhead(kinds);
}

bool Renderer::isPrepared(Mode mode, const PassPlan& plan) const {
    return impl_->runner.kernels.isPrepared(impl_->passOf(std::uint32_t(mode), false, plan));
}

void Renderer::setInteraction(Interaction interaction) { impl_->runner.interaction = std::move(interaction); }

UpdateReport Renderer::updateGuide(bool forget) {
    const UpdateReport report = impl_->guide.value().update(forget);
    impl_->runner.statistics.refusedSplits = report.refusedSplits;
    return report;
}

void Renderer::publishGuide() {
    if (impl_->guide)
        impl_->guide->publish();
}

void Renderer::discardRecords() {
    if (impl_->guide)
        impl_->guide->discardRecords();
}

bool Renderer::hasGuide() const { return impl_->guide.has_value(); }

const SdTree& Renderer::guide() const { return impl_->guide.value().tree; }

void Renderer::setGuide(SdTree tree) { impl_->guide.value().replace(std::move(tree)); }

void Renderer::setParameter(std::uint32_t parameter, std::span<const float> values) {
    impl_->buffers.setParameter(parameter, values);
    if (impl_->guide)
        impl_->guide->valuesChanged();
}

void Renderer::setSecondValues(std::uint32_t parameter, std::span<const float> values) {
    const RenderConfig& config = impl_->config;
    if (!config.frozenEvaluation && std::ranges::find(config.differentiable, parameter) == config.differentiable.end())
        throw std::logic_error("kernels of differences read second values of differentiable parameters alone");
    impl_->buffers.setSecond(parameter, values);
}

Image Renderer::render(const View& view, std::uint32_t spp, const PassKey& key, const PassPlan& plan, PassResult* result, Layers* layers) {
    impl_->openRecords(view, key, plan, impl_->passOf(kModeRender, layers != nullptr, plan));
    return impl_->image(kModeRender, view, spp, key, plan, result, layers);
}

ImageDifference Renderer::renderDifference(const View& view, std::uint32_t spp, const PassKey& key, const SampleRanges& samples,
                                           const PassPlan& plan, PassResult* result) {
    impl_->openRecords(view, key, plan, impl_->passOf(kModeDifference, false, plan));
    ImageDifference both{{}, Image(view.width, view.height, 3)};
    both.image = impl_->image(kModeDifference, view, spp, key, plan, result, nullptr, &both.difference, samples);
    return both;
}

Image Renderer::forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                        std::span<const std::vector<float>> directions, const PassPlan& plan, PassResult* result, Layers* layers) {
    impl_->openRecords(view, key, plan, impl_->runner.kernels.passOf(kModeRender, false, {}, false)); // the film of forward mode is no image
    impl_->uploadDirection(parameters, directions, plan, layers != nullptr);
    return impl_->image(kModeForward, view, spp, key, plan, result, layers);
}

void Renderer::render(const View& view, std::uint32_t spp, const PassKey& key, Film& film, const PassPlan& plan) {
    impl_->addTo(film, kModeRender, view, spp, key, plan);
}

void Renderer::forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                       std::span<const std::vector<float>> directions, Film& film, const PassPlan& plan) {
    impl_->uploadDirection(parameters, directions, plan, film.hasLayers());
    impl_->addTo(film, kModeForward, view, spp, key, plan);
}

void Renderer::renderDifference(const View& view, std::uint32_t spp, const PassKey& key, Film& film, const PassPlan& plan) {
    impl_->addTo(film, kModeDifference, view, spp, key, plan);
}

PassResult Renderer::reverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::span<const std::uint32_t> perPixel,
                             std::span<const float> weights, std::vector<std::vector<double>>& gradients, const PassPlan& plan, FirstVertices* firstVertices) {
    Impl& r = *impl_;
    if (adjoint.width != view.width || adjoint.height != view.height || adjoint.channels != 3)
        throw Error(ErrorKind::Usage, "the adjoint's size differs from the view's");
    PassInput in = passInput(view, key, spp);
    in.perPixel = perPixel;
    in.weights = weights;
    in.adjoint = &adjoint;
    in.firstVertices = firstVertices;
    in.plan = plan;
    const FeatureSet::Pass pass = r.passOf(kModeReverse, false, plan);
    const double radiance = r.pilotRadiance(view, key, pass), shortest = shortestNormal(r.scene, r.config.differentiable);
    if (r.guide && plan.record && plan.keepRecords)
        r.guide->openRecords([&] { return radiance; }, shortest);
    double adjointSum = 0;
    for (const float a : adjoint.values)
        adjointSum += std::abs(double(a)) / 3;

    GradientUnits units(adjointSum, radiance, shortest);
    PassResult result;
    const std::uint64_t entries = r.buffers.gradientEntries();
    for (bool first = true;; first = false) {
        in.surfaceScale = units.surfaceScale();
        in.normalScale = units.normalScale();
        in.emissionScale = units.emissionScale();
        clearSums(r.runner.pools().gradients, entries);
        const PassRunner::Outcome outcome = r.runner.run(pass, in, {});
        shareSums(r.runner.pools().gradients, entries, r.runner.ranks());
        if (first)
            result = outcome.result;
        else
            ++r.runner.statistics.repeatedPasses;
        in.plan.keepRecords = false; // once is enough
        if (!units.change(outcome.unsummed, [&] { return resolved(r.runner.pools().gradients, entries, outcome.unsummed); })) {
            r.runner.statistics.dropped["scan_tape: saturated gradient"] += outcome.unsummed.tooLarge;
            break;
        }
    }
    addSums(r.runner.pools().gradients, r.buffers, r.scene, r.config.differentiable, units, gradients);
    return result;
}

const RenderStatistics& Renderer::statistics() const { return impl_->runner.statistics; }

std::vector<std::pair<std::string, std::string>> Renderer::describeFeatures() const { return impl_->features.describe(); }

std::vector<KernelSize> Renderer::allocate(std::span<const Mode> modes, const PassPlan& plan) {
    for (const Mode m : modes)
        expect({m});
    std::vector<KernelSize> sizes;
    for (const Mode m : modes) {
        const FeatureSet::Pass pass = impl_->runner.kernels.passOf(std::uint32_t(m), false, plan, impl_->features.guiding);
        impl_->runner.kernels.allocate(pass);
        for (const KernelChoice& k : chooseKernels(impl_->features, pass)) {
            const SpirvSize size = spirvSize(impl_->device, k.name, k.constants);
            sizes.push_back({m, std::string(k.name), size.module, size.specialised});
        }
    }
    return sizes;
}

} // namespace cmpg

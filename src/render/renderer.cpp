// Passes: batches of samples in pixel order, the film and the gradients they leave.
#include "render/renderer.h"

#include "base/error.h"
#include "render/guide.h"
#include "render/moment_sum.h"
#include "render/pass_batches.h"
#include "render/pass_kernels.h"
#include "vk/spirv_size.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>

namespace cmpg {

namespace {

using gpu::kModeDifference, gpu::kModeForward, gpu::kModeRender, gpu::kModeReverse;

constexpr std::uint32_t kPilotSize = 32;  // edge of the pilot image that fixes the scale of the gradient sums
constexpr double kGradientBits = 48;      // gradient unit = 2^-48 of the pass's expected sum of magnitudes; 2^14 of headroom above it
constexpr int kCoarsening = 16;           // bits the units lose when the headroom was too little, and the pass is run again
constexpr int kCoarsenings = 3;           // at most: what is larger still has overflowed as a float
constexpr std::int64_t kResolved = 1 << 20; // units the largest sum of a pass should have, or rounding to whole ones shows
constexpr int kRefinement = 28;             // bits the units gain when it has not: then it has at most 2^48, what the unit was made for
constexpr int kRefinements = 2;             // at most: a second one for what the first unit rounded to nothing

// Decoding 8-bit texels at every look-up costs more than reading floats; only large textures nobody changes stay packed.
constexpr std::size_t kPackedTexels = std::size_t(1) << 20;

Scene& unpackSmallTextures(Scene& scene) {
    for (Parameter& p : scene.parameters)
        if (std::size_t(p.width) * p.height < kPackedTexels)
            p.materialise();
    return scene;
}

// What did not go into the gradient sums of a pass.
struct Unsummed {
    std::uint32_t tooLarge = 0; // contributions
    bool tooSmall = false;      // some were less than half a unit
};

// Sums over the samples of a pixel, so far.
struct Gathered {
    gpu::FilmPixel film{}, difference{};
    gpu::LayerSample layers{};
};

} // namespace

struct Renderer::Impl {
    Device& device;
    Scene& scene;
    RenderConfig config;
    FeatureSet features;
    SceneBuffers buffers;
    Interaction interaction;
    bool countersOpen = false; // the device's counters hold what a pass that ended early left
    RenderStatistics statistics;
    PassSampling sampling; // of the passes to come
    PassMeasure measure;   // of the last one
    // Paths of a batch whose copies find room in the pools, as the passes so far showed; at first a guess.
    std::uint32_t rouletteRoom = 1u << 14;
    std::optional<Guide> guide;
    PassKernels kernels;

    Impl(Device& d, Scene& s, const RenderConfig& c)
        : device(d), scene(unpackSmallTextures(s)), config(c),
          // Nothing is scattered at the last segment, so with one no light is sampled.
          features(analyse(s, {c.differentiable, c.lightSampling && c.maxDepth > 1, c.guiding, c.allFeatures})),
          buffers(d, s, features, c.differentiable, c.frozenEvaluation || c.differences),
          guide(features.guiding ? std::optional<Guide>(std::in_place, d, s, config) : std::nullopt),
          kernels(d, features, buffers, guideBuffers(), config) {}

    // Whether the guide has anything to draw from.
    bool learned() const { return guide && !guide->tree.empty(); }

    Pools& pools() { return kernels.pools(); }
    const Pools& pools() const { return kernels.pools(); }
    PassKernels::Kernels& prepare(const FeatureSet::Pass& pass) { return kernels.prepare(pass, interaction.compiling); }

    const GuideBuffers* guideBuffers() const { return guide ? &guide->buffers : nullptr; }

    // Calls receive(pixel, gathered) for every pixel, in order, when `film`.
    template <class Receive> Unsummed run(const FeatureSet::Pass& pass, bool film, const PassInput& in, Receive&& receive) {
        const bool layers = pass.layers;
        if (guide)
            guide->publish();
        PassKernels::Kernels& k = prepare(pass);
        if (countersOpen)
            countDropped();
        countersOpen = true;
        if (guide)
            guide->beginPass(pass, in.sampling, in.spp);
        Commands commands(device);
        k.wavefront.record(commands, buffers, pools(), guideBuffers(), film, in.sampling.keepRecords && !in.pilot);

        const bool differences = pass.mode == kModeDifference;
        const std::size_t pixels = std::size_t(in.width) * in.height;
        // Copies of split paths need room; how much shows as the pass goes on. Results do not depend on it.
        std::uint32_t most = pass.roulette ? std::min(rouletteRoom, pools().capacity) : pools().capacity;
        std::vector<std::uint32_t> offsets;
        std::vector<gpu::FilmPixel> tile, differenceTile;
        std::vector<gpu::LayerSample> layerTile;
        Gathered carry;
        BatchStart next;
        measure = {};
        MomentSum moments;
        while (next.pixel < pixels) {
            const BatchStart start = next;
            const bool bounded = interaction.submissionSeconds > 0;
            const gpu::Batch batch = nextBatch(in, bounded ? std::min(most, k.batchSize.paths()) : most, next, offsets);
            const bool split = next.sample > 0;
            pools().batch.upload(std::as_bytes(std::span(&batch, 1)));
            pools().pixelOffsets.uploadAll(offsets);
            std::vector<gpu::QueueCounts> counts(config.maxDepth + 1);
            counts[0].rays = batch.paths;
            counts[0].rayGroups = {(batch.paths + gpu::kTraceChunk - 1) / gpu::kTraceChunk, 1, 1};
            counts[0].vertexGroups = {(batch.paths + gpu::kVertexGroup - 1) / gpu::kVertexGroup, 1, 1};
            counts[0].arrivalGroups = counts[0].vertexGroups;
            pools().counts.uploadAll(counts);
            if (film) {
                beginTile(tile, batch, in.film ? &in.film->pixels : nullptr, carry.film);
                pools().film.uploadAll(tile);
                if (layers) {
                    beginTile(layerTile, batch, in.film ? &in.film->layerSums : nullptr, carry.layers);
                    pools().layerFilm.uploadAll(layerTile);
                }
                if (differences) {
                    beginTile<gpu::FilmPixel>(differenceTile, batch, nullptr, carry.difference);
                    pools().differenceFilm.uploadAll(differenceTile);
                }
            }
            if (pass.mode == kModeReverse)
                pools().adjoint.uploadAll(adjointTile(in, batch));
            submit(commands, batch.paths, k.batchSize);
            counts = pools().counts.downloadAll<gpu::QueueCounts>(config.maxDepth);
            if (counts[0].overflow) {
                next = start;
                most = std::max(1u, batch.paths / 2);
                continue;
            }
            if (pass.roulette && !in.pilot)
                most = rouletteRoom = roomFor(batch, counts);
            countRays(counts);
            if (pass.measure && !in.pilot) {
                const auto found = pools().pathMoments.downloadAll<gpu::PathMoment>(batch.paths);
                for (std::uint32_t p = 0; p < batch.pixels; ++p)
                    for (std::uint32_t i = offsets[p]; i < offsets[p + 1]; ++i)
                        moments.add(batch.firstPixel + p, found[i]);
            }
            if (!film)
                continue;
            tile = pools().film.downloadAll<gpu::FilmPixel>(batch.pixels);
            if (layers)
                layerTile = pools().layerFilm.downloadAll<gpu::LayerSample>(batch.pixels);
            if (differences)
                differenceTile = pools().differenceFilm.downloadAll<gpu::FilmPixel>(batch.pixels);
            const auto gathered = [&](std::size_t i) {
                return Gathered{tile[i], differences ? differenceTile[i] : gpu::FilmPixel{}, layers ? layerTile[i] : gpu::LayerSample{}};
            };
            const std::size_t complete = batch.pixels - (split ? 1 : 0);
            for (std::size_t i = 0; i < complete; ++i)
                receive(batch.firstPixel + i, gathered(i));
            carry = split ? gathered(complete) : Gathered{};
        }
        if (pass.measure && !in.pilot) {
            measure.variance = moments.variance();
            measure.reference = moments.reference() / double(pixels);
            measure.concentration = moments.concentration();
        }
        return countDropped();
    }

    void submit(Commands& commands, std::uint32_t paths, BatchSize& batchSize) const {
        if (interaction.beforeSubmission)
            interaction.beforeSubmission();
        const auto start = std::chrono::steady_clock::now();
        commands.submitAndWait();
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        if (interaction.submissionSeconds > 0)
            batchSize.observe(paths, taken.count(), interaction.submissionSeconds);
    }

    // Paths of the next batch, from how many vertices the last one's made at their fullest bounce.
    std::uint32_t roomFor(const gpu::Batch& batch, const std::vector<gpu::QueueCounts>& counts) const {
        constexpr double kReserve = 0.8;
        std::uint32_t fullest = 1;
        for (const gpu::QueueCounts& c : counts)
            fullest = std::max(fullest, c.vertices);
        const double fits = kReserve * pools().capacity * double(std::max(batch.paths, 1u)) / fullest;
        return std::uint32_t(std::clamp(fits, 1.0, double(pools().capacity)));
    }

    void countRays(const std::vector<gpu::QueueCounts>& counts) {
        statistics.paths += counts[0].rays;
        measure.paths += counts[0].rays;
        for (const gpu::QueueCounts& c : counts) {
            const std::uint64_t rays = std::uint64_t(c.rays) + c.shadowRays;
            statistics.rays += rays;
            measure.rays += rays;
            statistics.dropped["trace: unfinished rays"] += c.unfinished;
            if (c.drawn == 0)
                continue;
            statistics.guided.resize(config.maxDepth);
            GuidedDepth& depth = statistics.guided[std::size_t(&c - counts.data())];
            depth.drawn += c.drawn;
            depth.guided += c.guided;
            depth.dead += c.dead;
            depth.lightShare += double(c.lightShare) / gpu::kShareUnits;
        }
    }

    Unsummed countDropped() {
        auto counters = pools().statistics.downloadAll<std::uint32_t>(gpu::kStatisticsCount);
        statistics.dropped["shade_vertex: non-finite radiance"] += counters[gpu::kDroppedRadiance];
        statistics.dropped["scan_tape: non-finite derivative"] += counters[gpu::kDroppedDerivative];
        statistics.dropped["gather_film: non-finite sample"] += counters[gpu::kDroppedPixel];
        statistics.dropped["scan_tape: saturated guide record"] += counters[gpu::kSaturatedRecord];
        const Unsummed unsummed{counters[gpu::kSaturatedGradient], counters[gpu::kLostGradient] != 0};
        std::fill(counters.begin(), counters.end(), 0u);
        pools().statistics.uploadAll(counters);
        countersOpen = false;
        return unsummed;
    }

    Image image(std::uint32_t mode, const View& view, std::uint32_t spp, const PassKey& key, Layers* layers, Image* difference = nullptr,
                std::span<const std::uint32_t> counts = {}) {
        PassInput in = passInput(view, key, spp);
        in.perPixel = counts;
        in.sampling = sampling;
        Image result(view.width, view.height, 3);
        double variance = 0; // of the pixels' means, summed
        if (layers)
            *layers = Layers(view.width, view.height, spp, layerDepths());
        run(passOf(mode, layers != nullptr), true, in, [&](std::size_t pixel, const Gathered& g) {
            const std::uint32_t count = in.samples(pixel);
            const glm::dvec4 means = filmSums(g.film) / double(count);
            for (int c = 0; c < 3; ++c)
                result.values[3 * pixel + c] = float(means[c]);
            if (difference)
                for (int c = 0; c < 3; ++c)
                    difference->values[3 * pixel + c] = meanOf(g.difference, count)[c];
            variance += std::max(0.0, means.w - glm::dot(glm::dvec3(means), glm::dvec3(means)) / 3) / double(std::max(1u, count - 1));
            if (layers)
                layers->set(pixel, g.layers);
        });
        measure.variance = variance;
        return result;
    }

    // That layers tell of: nothing is drawn at the last one.
    std::uint32_t layerDepths() const { return std::min(gpu::kLayerDepths, config.maxDepth - 1); }

    // Leaves no records.
    void addTo(Film& film, std::uint32_t mode, const View& view, std::uint32_t spp, const PassKey& key) {
        if (film.width != view.width || film.height != view.height)
            throw Error(ErrorKind::Usage, "the film's size differs from the view's");
        PassInput in = passInput(view, key, spp);
        in.sampling = sampling;
        in.sampling.record = false;
        in.film = &film;
        Film sum(film.width, film.height, film.hasLayers());
        run(kernels.passOf(mode, film.hasLayers(), in.sampling, learned()), true, in, [&](std::size_t pixel, const Gathered& g) {
            sum.pixels[pixel] = g.film;
            if (sum.hasLayers())
                sum.layerSums[pixel] = g.layers;
        });
        sum.samples = film.samples + spp;
        sum.layerDepths = layerDepths();
        film = std::move(sum);
    }

    // Before the pools are filled for the pass: the pilot image may need other ones.
    void openRecords(const View& view, const PassKey& key, const FeatureSet::Pass& pilot) {
        if (guide && sampling.record && sampling.keepRecords)
            guide->openRecords([&] { return pilotRadiance(view, key, pilot); }, shortestNormal());
    }

    void uploadDirection(std::span<const std::uint32_t> parameters, std::span<const std::vector<float>> directions, bool layers) {
        prepare(kernels.passOf(kModeForward, layers, sampling, learned())); // has the buffer made
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
        pools().direction.uploadAll(direction);
    }

    // Length of the shortest vector of the differentiable normals, by whose inverse their derivatives grow; at most 1, and not so short
    // that a few texels near zero cost the others' accuracy.
    double shortestNormal() const {
        double shortest2 = 1;
        for (const std::uint32_t i : config.differentiable) {
            const Parameter& p = scene.parameters[i];
            if (p.kind == SlotKind::Normal)
                for (std::size_t k = 0; k + 2 < p.values.size(); k += 3) {
                    const glm::dvec3 t(p.values[k], p.values[k + 1], p.values[k + 2]);
                    shortest2 = std::min(shortest2, glm::dot(t, t));
                }
        }
        return std::max(std::sqrt(shortest2), 0x1p-10);
    }

    void clearSums() {
        const std::uint64_t entries = buffers.gradientEntries();
        const std::vector<std::int64_t> zeros(std::min<std::uint64_t>(entries, 1u << 20), 0);
        for (std::uint64_t at = 0; at < entries; at += zeros.size())
            pools().gradients.upload(std::as_bytes(std::span(zeros)).first(8 * std::min<std::uint64_t>(zeros.size(), entries - at)), 8 * at);
    }

    // Whether something was contributed to the gradient sums, but no sum is large enough for rounding not to show. Looks no further
    // than the first that is.
    bool poorlyResolved(const Unsummed& unsummed) {
        constexpr std::uint64_t kPortion = 1u << 18;
        bool contributed = unsummed.tooSmall;
        for (std::uint64_t at = 0, entries = buffers.gradientEntries(); at < entries; at += kPortion)
            for (const std::int64_t sum : pools().gradients.downloadAll<std::int64_t>(std::min(kPortion, entries - at), 8 * at)) {
                if (sum >= kResolved || sum <= -kResolved)
                    return false;
                contributed = contributed || sum != 0;
            }
        return contributed;
    }

    // Of the next pass.
    FeatureSet::Pass passOf(std::uint32_t mode, bool layers) const { return kernels.passOf(mode, layers, sampling, learned()); }

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
        run(pass, true, in, [&](std::size_t, const Gathered& g) {
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
        impl_->prepare(impl_->kernels.passOf(std::uint32_t(m), layers && m != Mode::Reverse, {}, false));
}

void Renderer::prepare(Mode mode, const PassSampling& sampling, bool layers, bool learned) {
    impl_->prepare(impl_->kernels.passOf(std::uint32_t(mode), layers, sampling, learned || impl_->learned()));
}

void Renderer::expect(std::initializer_list<Mode> modes) {
    for (const Mode m : modes)
        impl_->kernels.expect(std::uint32_t(m));
}

void Renderer::prepareAhead(std::span<const std::pair<Mode, PassSampling>> passes) {
    std::vector<FeatureSet::Pass> kinds;
    for (const auto& [mode, sampling] : passes)
        kinds.push_back(impl_->kernels.passOf(std::uint32_t(mode), false, sampling, impl_->learned()));
    impl_->kernels.prepareAhead(kinds);
}

bool Renderer::isPrepared(Mode mode, const PassSampling& sampling) const {
    return impl_->kernels.isPrepared(impl_->kernels.passOf(std::uint32_t(mode), false, sampling, impl_->learned()));
}

void Renderer::setInteraction(Interaction interaction) { impl_->interaction = std::move(interaction); }

void Renderer::setSampling(const PassSampling& sampling) { impl_->sampling = sampling; }

const PassMeasure& Renderer::lastPass() const { return impl_->measure; }

UpdateReport Renderer::updateGuide() {
    const UpdateReport report = impl_->guide.value().update();
    impl_->statistics.refusedSplits = report.refusedSplits;
    return report;
}

void Renderer::publishGuide() {
    if (impl_->guide)
        impl_->guide->publish();
}

void Renderer::discardRecords() { impl_->guide.value().discardRecords(); }

bool Renderer::hasGuide() const { return impl_->guide.has_value(); }

const SdTree& Renderer::guide() const { return impl_->guide.value().tree; }

void Renderer::setGuide(SdTree tree) { impl_->guide.value().replace(std::move(tree)); }

void Renderer::setParameter(std::uint32_t parameter, std::span<const float> values) { impl_->buffers.setParameter(parameter, values); }

void Renderer::setSecondValues(std::uint32_t parameter, std::span<const float> values) { impl_->buffers.setSecond(parameter, values); }

Image Renderer::render(const View& view, std::uint32_t spp, const PassKey& key, Layers* layers) {
    impl_->openRecords(view, key, impl_->passOf(kModeRender, layers != nullptr));
    return impl_->image(kModeRender, view, spp, key, layers);
}

ImageDifference Renderer::renderDifference(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> counts) {
    impl_->openRecords(view, key, impl_->passOf(kModeDifference, false));
    ImageDifference result{{}, Image(view.width, view.height, 3)};
    result.image = impl_->image(kModeDifference, view, spp, key, nullptr, &result.difference, counts);
    return result;
}

Image Renderer::forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                        std::span<const std::vector<float>> directions, Layers* layers) {
    impl_->openRecords(view, key, impl_->kernels.passOf(kModeRender, false, {}, false)); // the film of forward mode is no image
    impl_->uploadDirection(parameters, directions, layers != nullptr);
    return impl_->image(kModeForward, view, spp, key, layers);
}

void Renderer::render(const View& view, std::uint32_t spp, const PassKey& key, Film& film) { impl_->addTo(film, kModeRender, view, spp, key); }

void Renderer::forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                       std::span<const std::vector<float>> directions, Film& film) {
    impl_->uploadDirection(parameters, directions, film.hasLayers());
    impl_->addTo(film, kModeForward, view, spp, key);
}

void Renderer::reverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::span<const std::uint32_t> perPixel,
                       std::span<const float> weights, std::vector<std::vector<double>>& gradients) {
    Impl& r = *impl_;
    if (adjoint.width != view.width || adjoint.height != view.height || adjoint.channels != 3)
        throw Error(ErrorKind::Usage, "the adjoint's size differs from the view's");
    PassInput in = passInput(view, key, spp);
    in.perPixel = perPixel;
    in.weights = weights;
    in.adjoint = &adjoint;
    in.sampling = r.sampling;
    const FeatureSet::Pass pass = r.passOf(kModeReverse, false);
    const double radiance = r.pilotRadiance(view, key, pass);
    if (r.guide && r.sampling.record && r.sampling.keepRecords)
        r.guide->openRecords([&] { return radiance; }, r.shortestNormal());
    double adjointSum = 0;
    for (const float a : adjoint.values)
        adjointSum += std::abs(double(a)) / 3;
    const double normalGrowth = 1 / r.shortestNormal();
    double surfaceUnit = 1, normalUnit = 1, emissionUnit = 1;

    // The expectation can be far too small: a black scene has derivatives and no radiance. Then units get coarser until sums fit. Or far
    // too large: what is bright need not depend on a parameter. Then they get finer, unless sums are small because large contributions
    // cancel, which the finer unit cannot hold. Never both, and what comes of it depends on this pass alone.
    int coarser = 0, finer = 0;
    bool cancelled = false;
    PassMeasure measure;
    for (bool first = true;; first = false) {
        const double expected = std::ldexp(adjointSum, kCoarsening * coarser - kRefinement * finer);
        in.surfaceScale = fixedPointScale(expected * radiance, kGradientBits, surfaceUnit);
        in.normalScale = fixedPointScale(expected * radiance * normalGrowth, kGradientBits, normalUnit);
        in.emissionScale = fixedPointScale(expected, kGradientBits, emissionUnit);
        r.clearSums();
        const Unsummed unsummed = r.run(pass, false, in, [](std::size_t, const Gathered&) {});
        if (first)
            measure = r.measure;
        else
            ++r.statistics.repeatedPasses;
        in.sampling.keepRecords = false; // once is enough
        if (unsummed.tooLarge > 0 && finer > 0) {
            cancelled = true;
            --finer;
        } else if (unsummed.tooLarge > 0 && coarser < kCoarsenings) {
            ++coarser;
        } else if (unsummed.tooLarge == 0 && coarser == 0 && finer < kRefinements && !cancelled && r.poorlyResolved(unsummed)) {
            ++finer;
        } else {
            r.statistics.dropped["scan_tape: saturated gradient"] += unsummed.tooLarge;
            break;
        }
    }

    r.measure = measure;

    gradients.resize(r.config.differentiable.size());
    for (std::size_t i = 0; i < gradients.size(); ++i) {
        const Parameter& p = r.scene.parameters[r.config.differentiable[i]];
        const bool emits = p.kind == SlotKind::Emission || p.kind == SlotKind::Radiance;
        const double unit = emits ? emissionUnit : p.kind == SlotKind::Normal ? normalUnit : surfaceUnit;
        gradients[i].resize(p.entries(), 0.0);
        const auto sums = r.pools().gradients.downloadAll<std::int64_t>(p.entries(), 8 * r.buffers.gradientOffset(i));
        for (std::size_t k = 0; k < sums.size(); ++k)
            gradients[i][k] += double(sums[k]) * unit;
    }
}

const RenderStatistics& Renderer::statistics() const { return impl_->statistics; }

std::vector<std::pair<std::string, std::string>> Renderer::describeFeatures() const { return impl_->features.describe(); }

std::vector<KernelSize> Renderer::allocate(std::initializer_list<Mode> modes) {
    expect(modes);
    std::vector<KernelSize> sizes;
    for (const Mode m : modes) {
        const FeatureSet::Pass pass = impl_->kernels.passOf(std::uint32_t(m), false, impl_->sampling, impl_->features.guiding);
        impl_->kernels.allocate(pass);
        for (const KernelChoice& k : chooseKernels(impl_->features, pass)) {
            const SpirvSize size = spirvSize(impl_->device, k.name, k.constants);
            sizes.push_back({m, std::string(k.name), size.module, size.specialised});
        }
    }
    return sizes;
}

} // namespace cmpg

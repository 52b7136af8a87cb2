// Passes with directions drawn as a user asked: learning, the automatic choice of a kind, positivization, the gate of the roulette.
#include "render/guided_passes.h"

#include "base/error.h"
#include "base/stopwatch.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cmpg {
namespace {

constexpr std::uint32_t kLearningPass = 3, kGatePass = 4, kSecondHalf = 5, kNegativeHalf = 8;
constexpr std::uint32_t kGatePasses = 2; // of each way
constexpr double kRecordCost = 0.33;     // of recording and measuring, in passes
constexpr double kMostNoise = 100;       // what is told of a gradient that is noise alone

bool isImage(Renderer::Mode mode) { return mode == Renderer::Mode::Render || mode == Renderer::Mode::Difference; }

std::vector<SamplingWay> waysOf(Sampling asked, bool derivatives, bool roulette) {
    std::vector<Sampling> kinds{asked};
    if (asked == Sampling::Auto)
        kinds = derivatives ? std::vector{Sampling::Bsdf, Sampling::Conditional, Sampling::Primal} : std::vector{Sampling::Bsdf, Sampling::Primal};
    std::vector<SamplingWay> ways;
    for (const bool r : {false, true})
        for (const Sampling k : kinds)
            if (!r || roulette)
                ways.push_back({k, r});
    return ways;
}

// Sum of squares, and mean over the pixels of mean_rgb |adjoint|.
std::pair<double, double> norms(const Image& adjoint) {
    double squares = 0, sum = 0;
    for (const float a : adjoint.values)
        if (std::isfinite(a)) {
            squares += double(a) * double(a);
            sum += std::abs(double(a));
        }
    return {squares, sum / double(std::max<std::size_t>(1, adjoint.values.size()))};
}

PassKey secondHalf(const PassKey& key) { return {key.seed, key.step, key.pass + kSecondHalf}; }

// Of a pass in two halves: paths and rays of both, what it measured on average.
PassMeasure meanOf(PassMeasure a, const PassMeasure& b) {
    a.add(b);
    a.variance /= 2;
    a.reference /= 2;
    return a;
}

// Of an image: their squares add up to means over the channels, as PassMeasure::variance does.
std::vector<double> entries(const Image& image) {
    std::vector<double> all(image.values.begin(), image.values.end());
    for (double& v : all)
        v /= std::sqrt(double(image.channels));
    return all;
}

// sum[p][i] += (a[p][i] + sign b[p][i]) / 2
void addHalf(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b, double sign, std::vector<std::vector<double>>& sum) {
    sum.resize(a.size());
    for (std::size_t p = 0; p < a.size(); ++p) {
        sum[p].resize(a[p].size());
        for (std::size_t i = 0; i < a[p].size(); ++i)
            sum[p][i] += 0.5 * (a[p][i] + sign * b[p][i]);
    }
}

std::vector<double> entries(const std::vector<std::vector<double>>& gradients) {
    std::vector<double> all;
    for (const std::vector<double>& g : gradients)
        all.insert(all.end(), g.begin(), g.end());
    return all;
}

} // namespace

struct GuidedPasses::Impl {
    Renderer& renderer;
    GuidedOptions options;
    SamplingChoice images, derivatives; // ways of primal passes, and of derivative passes in either mode
    bool trained = false;               // by passes of this run or of the one that saved the guide
    double reference = 0;               // of the roulette, for a mean |adjoint| of 1
    Exploration exploration;
    struct Figures {
        SamplingChoice images, derivatives;
        Exploration exploration;
        double reference;
    };
    Figures stepStart{images, derivatives, exploration, 0}; // what an abandoned step goes back to
    bool learning = false, gating = false; // the passes to come are for the guide; for the gate of the roulette
    // How a step that learns draws. It holds for all its views.
    struct Plan {
        SamplingWay image, derivative;
        bool record = false;
        bool halves = false; // derivative passes: to tell their noise
        bool trial = false, imageTrial = false;
        std::uint32_t newKinds = 0; // of passes, for a trial
    };
    Plan plan;
    struct StepSums {
        std::uint64_t rays = 0;
        std::vector<double> noise, signal; // by parameter: squared standard error of the gradient, squared length; of halves
    };
    StepSums sums;
    std::uint32_t step = 0;
    double seconds = 0, concentration = 0;

    Impl(Renderer& r, const GuidedOptions& o)
        : renderer(r), options(o), images(waysOf(o.sampling, false, false)), derivatives(waysOf(o.sampling, true, o.roulette)) {
        beginStep();
    }

    SamplingWay imageWay() const { return learning ? plan.image : images.best(); }
    SamplingWay derivativeWay() const {
        if (learning)
            return plan.derivative;
        return trained ? derivatives.best() : SamplingWay{derivatives.ways()[0].kind, false};
    }

    // How the next pass of a mode is drawn.
    PassSampling nextPass(Renderer::Mode mode) const {
        const bool image = isImage(mode);
        const SamplingWay way = image ? imageWay() : derivativeWay();
        PassSampling sampling = kernelsOf(recording());
        sampling.kind = way.kind;
        sampling.roulette = way.roulette && mode == Renderer::Mode::Reverse;
        sampling.sign = options.positivize && !image;
        return sampling;
    }

    // The steps that learn share their kernels, whatever the ways that they try.
    PassSampling kernelsOf(bool record) const {
        const auto has = [&](auto&& what) { return std::any_of(derivatives.ways().begin(), derivatives.ways().end(), what); };
        return {.record = record,
                .guidedKernels = record && learning && has([](const SamplingWay& w) { return w.kind != Sampling::Bsdf; }),
                .rouletteKernels = record && learning && has([](const SamplingWay& w) { return w.roulette; })};
    }

    // What is drawn by when nothing is learned.
    SamplingWay settledWay(const SamplingChoice& choice) const { return {trained ? choice.best().kind : choice.ways()[0].kind, false}; }

    void beginStep() {
        stepStart = {images, derivatives, exploration, reference};
        sums = {};
        plan = {.image = images.ways().front(), .derivative = derivatives.ways().front()};
        const std::optional<SamplingChoice::Trial> imageTrial = images.trial();
        if (const std::optional<SamplingChoice::Trial> trial = derivatives.trial()) {
            planTrial(*trial);
        } else {
            plan.derivative = derivatives.next(step);
            plan.halves = derivatives.tries(step);
            plan.record = !(derivatives.rests(step) && (imageTrial || images.rests(step)));
        }
        // Images are tried beside derivatives, whose kernels are made for both.
        plan.imageTrial = plan.record && imageTrial;
        if (!imageTrial)
            plan.image = images.next(step);
        else if (plan.imageTrial)
            plan.image = imageTrial->way;
    }

    void planTrial(const SamplingChoice::Trial& trial) {
        const std::uint32_t newKinds = trial.first ? 2 : 0; // images are recorded, too
        const bool asked = options.atOnce || derivatives.ways().front() != SamplingWay{}; // for a guide
        if (asked || exploration.allows(newKinds)) {
            plan.derivative = trial.way;
            plan.record = plan.trial = true;
            plan.halves = trial.measured;
            plan.newKinds = newKinds;
        } else {
            plan.halves = exploration.watches(step);
        }
    }

    bool recording() const { return learning && plan.record; }

    // Of a derivative pass in halves, whose mean is in `gradients` now.
    void addNoise(const std::vector<std::vector<double>>& a, const std::vector<std::vector<double>>& b, const std::vector<std::vector<double>>& gradients) {
        sums.noise.resize(gradients.size());
        sums.signal.resize(gradients.size());
        for (std::size_t p = 0; p < gradients.size(); ++p) {
            double noise = 0, signal = 0;
            for (std::size_t k = 0; k < gradients[p].size(); ++k) {
                const double difference = a[p][k] - b[p][k], mean = gradients[p][k];
                if (std::isfinite(difference) && std::isfinite(mean)) {
                    noise += difference * difference / 4;
                    signal += mean * mean;
                }
            }
            sums.noise[p] += noise;
            sums.signal[p] = signal; // of all views so far
        }
    }

    // Of a step: noise over signal, of the parameter whose gradient has most.
    std::optional<double> noise() const {
        std::optional<double> most;
        for (std::size_t p = 0; p < sums.noise.size(); ++p)
            if (sums.noise[p] > 0)
                most = std::max(most.value_or(0), sums.noise[p] / std::max(sums.signal[p] - sums.noise[p], sums.noise[p] / kMostNoise));
        return most;
    }

    void finishStep() {
        if (plan.halves && plan.derivative == SamplingWay{})
            if (const std::optional<double> told = noise())
                exploration.observeNoise(*told);
        const double kernels = kKernelRays * plan.newKinds, rays = double(sums.rays);
        exploration.spend(rays + kernels, kernels + (plan.trial ? kRecordCost * rays : 0));
        if (plan.trial)
            derivatives.endTrial(plan.derivative);
        if (plan.imageTrial)
            images.endTrial(plan.image);
    }

    SamplingDecision decide(const SamplingChoice& choice) const {
        SamplingDecision d;
        const SamplingWay way = trained ? choice.best() : choice.ways()[0];
        d.kind = way.kind;
        d.roulette = trained && way.roulette;
        for (std::size_t i = 0; i < choice.ways().size(); ++i)
            if (choice.figures(i).passes > 0)
                (choice.ways()[i].roulette ? d.rouletteFigures : d.figures)[choice.ways()[i].kind] = choice.figures(i);
        return d;
    }

    // Two results of one pass with numbers of their own, whose variance moments of single paths put at `moments`.
    static void compare(SamplingChoice& choice, const SamplingWay& way, std::span<const double> a, std::span<const double> b, double moments) {
        PassDifferences differences;
        differences.add(a);
        differences.add(b);
        if (differences.variance() && moments > 0)
            choice.observeRepetition(way, *differences.variance() / moments);
    }

    void use(const SamplingWay& way, bool record, int sign = 0, double meanAdjoint = 0) {
        PassSampling sampling = kernelsOf(record);
        sampling.kind = way.kind;
        sampling.measure = gating;
        sampling.roulette = way.roulette;
        sampling.sign = sign;
        sampling.reference = reference * meanAdjoint;
        renderer.setSampling(sampling);
    }

    // Records and measures one pass of any mode, then rebuilds. `run` returns its result, entry by entry.
    template <class Pass> void learn(SamplingChoice& choice, std::uint32_t spp, std::uint32_t pass, double adjointSquares, Pass&& run) {
        std::vector<SamplingWay> ways;
        for (const SamplingWay& w : choice.ways())
            if (!w.roulette)
                ways.push_back(w);
        const SamplingWay way = ways[pass % ways.size()];
        use(way, true);
        const std::vector<double> result = run();
        const PassMeasure m = renderer.lastPass();
        if (adjointSquares > 0 && m.paths > 0) {
            const double unit = spp / adjointSquares;
            choice.observe(way, m.variance * unit, double(m.rays) / double(m.paths));
            choice.observeResult(way, result, unit);
        }
        renderer.updateGuide();
        renderer.publishGuide();
        beginStep();
    }

    std::uint64_t reverse(const View& view, std::uint32_t spp, PassKey key, const Image& adjoint, double meanAdjoint, const SamplingWay& way, int sign,
                          std::vector<std::vector<double>>& gradients) {
        use(way, recording(), sign, meanAdjoint);
        return sampledReverse(view, spp, key, adjoint, gradients);
    }

    // Drawn as the renderer is told.
    std::uint64_t sampledReverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients) {
        PixelSamples samples;
        if (options.pixels == PixelSampling::Adjoint)
            samples = sampleCounts(adjoint, spp, key);
        renderer.reverse(view, spp, key, adjoint, samples.counts, samples.weights, gradients);
        return renderer.lastPass().paths;
    }

    // Learned from, if steps learn. `half`: as in reverseHalves(); null: whole, unless the halves are to tell something.
    std::uint64_t learnedReverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                 std::vector<std::vector<double>>& gradients, std::vector<std::vector<double>>* half);

    // Variance and rays with and without roulette, as the measured pass will run: pixel sampling included. In the units of the learning
    // passes, which ran without either.
    void gate(const View& view, std::uint32_t spp, std::uint64_t seed, const Image& adjoint, double meanAdjoint) {
        if (!options.roulette || !(reference > 0))
            return;
        const Sampling kind = derivatives.bestKind();
        PassMeasure measured[2];
        PassDifferences differences[2];
        gating = true;
        for (std::uint32_t pass = 0; pass < kGatePasses; ++pass)
            for (const bool roulette : {false, true}) {
                std::vector<std::vector<double>> gradients;
                reverse(view, spp, {seed, pass, kGatePass}, adjoint, meanAdjoint, {kind, roulette}, 0, gradients);
                measured[roulette].add(renderer.lastPass());
                differences[roulette].add(entries(gradients));
            }
        gating = false;
        if (!(measured[0].variance > 0) || measured[0].rays == 0)
            return;
        const double variances = worseVarianceRatio(measured[1].variance / measured[0].variance, differences[1], differences[0]);
        derivatives.observeRoulette(kind, variances, double(measured[1].rays) / double(measured[0].rays));
    }
};

GuidedPasses::GuidedPasses(Renderer& renderer, const GuidedOptions& options) : impl_(std::make_unique<Impl>(renderer, options)) {}
GuidedPasses::~GuidedPasses() = default;

void GuidedPasses::prepare(std::initializer_list<Renderer::Mode> modes) {
    for (const Renderer::Mode mode : modes) {
        if (impl_->learning) { // steps that learn, and others
            impl_->renderer.prepare(mode, impl_->kernelsOf(true));
            impl_->renderer.prepare(mode, {});
            continue;
        }
        for (const SamplingWay& way : (isImage(mode) ? impl_->images : impl_->derivatives).ways())
            if (!way.roulette || mode == Renderer::Mode::Reverse)
                impl_->renderer.prepare(mode, {.kind = way.kind, .roulette = way.roulette}, false, true);
    }
}

void GuidedPasses::prepareNext(Renderer::Mode mode, bool layers) {
    impl_->renderer.prepare(mode, impl_->nextPass(mode), layers);
}

void GuidedPasses::prepareAhead(std::initializer_list<Renderer::Mode> modes) {
    std::vector<std::pair<Renderer::Mode, PassSampling>> passes;
    for (const Renderer::Mode mode : modes)
        passes.emplace_back(mode, impl_->nextPass(mode));
    impl_->renderer.prepareAhead(passes);
}

void GuidedPasses::trainRender(const View& view, std::uint32_t spp, std::uint32_t passes, std::uint64_t seed, std::uint32_t first) {
    const ScopedTime time(impl_->seconds);
    for (std::uint32_t i = first; i < first + passes; ++i)
        impl_->learn(impl_->images, spp, i, 1, [&] { return entries(impl_->renderer.render(view, spp, {seed, i, kLearningPass})); });
    impl_->trained |= passes > 0;
}

void GuidedPasses::trainForward(const View& view, std::uint32_t spp, std::uint32_t passes, std::uint64_t seed,
                                std::span<const std::uint32_t> parameters, std::span<const std::vector<float>> directions, std::uint32_t first) {
    const ScopedTime time(impl_->seconds);
    for (std::uint32_t i = first; i < first + passes; ++i)
        impl_->learn(impl_->derivatives, spp, i, 1,
                     [&] { return entries(impl_->renderer.forward(view, spp, {seed, i, kLearningPass}, parameters, directions)); });
    impl_->trained |= passes > 0;
}

void GuidedPasses::trainReverse(const View& view, std::uint32_t spp, std::uint32_t passes, std::uint64_t seed, const Image& adjoint) {
    const ScopedTime time(impl_->seconds);
    const auto [squares, mean] = norms(adjoint);
    for (std::uint32_t i = 0; i < passes; ++i) {
        impl_->learn(impl_->derivatives, spp, i, squares, [&] {
            std::vector<std::vector<double>> gradients;
            impl_->renderer.reverse(view, spp, {seed, i, kLearningPass}, adjoint, {}, {}, gradients);
            return entries(gradients);
        });
        if (mean > 0)
            impl_->reference = impl_->renderer.lastPass().reference / mean;
    }
    if (passes > 0)
        impl_->gate(view, spp, seed, adjoint, mean);
    impl_->trained |= passes > 0;
}

Image GuidedPasses::render(const View& view, std::uint32_t spp, const PassKey& key, Layers* layers) {
    Impl& p = *impl_;
    const SamplingWay way = p.imageWay();
    p.use(way, p.recording());
    Image image = p.renderer.render(view, spp, key, layers);
    const PassMeasure m = p.renderer.lastPass();
    p.sums.rays += m.rays;
    if (p.recording() && m.paths > 0)
        p.images.observe(way, m.variance * spp, double(m.rays) / double(m.paths));
    return image;
}

ImageHalves GuidedPasses::renderHalves(const View& view, std::uint32_t spp, const PassKey& key, bool difference, std::span<const std::uint32_t> counts) {
    Impl& p = *impl_;
    const SamplingWay way = p.imageWay();
    p.use(way, p.recording());
    ImageHalves halves{{}, counts.empty() ? std::max(1u, spp / 2) : *std::max_element(counts.begin(), counts.end()), {counts.begin(), counts.end()}};
    PassMeasure sum;
    for (std::uint32_t h = 0; h < 2; ++h) {
        const PassKey own{key.seed, key.step, key.pass + (h == 0 ? 0 : kSecondHalf), key.firstSample};
        if (difference)
            halves.half[h] = p.renderer.renderDifference(view, halves.samples, own, counts);
        else
            halves.half[h].image = p.renderer.render(view, halves.samples, own);
        sum.add(p.renderer.lastPass());
    }
    p.sums.rays += sum.rays;
    if (p.recording() && sum.paths > 0) {
        PassDifferences differences;
        for (const ImageDifference& half : halves.half)
            differences.add(entries(half.image));
        if (const std::optional<double> variance = differences.variance())
            p.images.observe(way, *variance * std::max(1u, spp / 2), double(sum.rays) / double(sum.paths));
    }
    return halves;
}

Image GuidedPasses::forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                            std::span<const std::vector<float>> directions, Layers* layers) {
    const SamplingWay way{impl_->derivativeWay().kind, false};
    if (!impl_->options.positivize) {
        impl_->use(way, impl_->recording());
        return impl_->renderer.forward(view, spp, key, parameters, directions, layers);
    }
    const std::uint32_t half = std::max(1u, spp / 2);
    impl_->use(way, impl_->recording(), 1);
    Image gradient = impl_->renderer.forward(view, half, key, parameters, directions);
    impl_->use(way, impl_->recording(), -1);
    const Image negative = impl_->renderer.forward(view, half, {key.seed, key.step, key.pass + kNegativeHalf}, parameters, directions);
    for (std::size_t i = 0; i < gradient.values.size(); ++i)
        gradient.values[i] += negative.values[i];
    return gradient;
}

Image GuidedPasses::picture(const View& view, std::uint32_t spp, const PassKey& key) {
    PassSampling sampling{.kind = impl_->settledWay(impl_->images).kind};
    if (impl_->recording() && !impl_->renderer.isPrepared(Renderer::Mode::Render, sampling)) { // others would have to be compiled
        const Sampling kind = sampling.kind;
        sampling = impl_->kernelsOf(true);
        sampling.kind = kind;
    }
    sampling.keepRecords = false;
    impl_->renderer.setSampling(sampling);
    return impl_->renderer.render(view, spp, key);
}

void GuidedPasses::render(const View& view, std::uint32_t spp, const PassKey& key, Film& film) {
    impl_->use(impl_->settledWay(impl_->images), false);
    impl_->renderer.render(view, spp, key, film);
}

void GuidedPasses::forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                           std::span<const std::vector<float>> directions, Film& film) {
    impl_->use(impl_->settledWay(impl_->derivatives), false);
    impl_->renderer.forward(view, spp, key, parameters, directions, film);
}

std::uint64_t GuidedPasses::reverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                    std::vector<std::vector<double>>& gradients) {
    return impl_->learnedReverse(view, spp, key, adjoint, gradients, nullptr);
}

std::uint64_t GuidedPasses::reverseHalves(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                          std::vector<std::vector<double>>& gradients, std::vector<std::vector<double>>& half) {
    return impl_->learnedReverse(view, spp, key, adjoint, gradients, &half);
}

std::uint64_t GuidedPasses::Impl::learnedReverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                                 std::vector<std::vector<double>>& gradients, std::vector<std::vector<double>>* half) {
    Impl& p = *this;
    const SamplingWay way = p.derivativeWay();
    const std::pair<double, double> adjointNorms = norms(adjoint);
    const double squares = adjointNorms.first, mean = adjointNorms.second;
    const auto estimate = [&](std::uint32_t samples, const PassKey& k, std::vector<std::vector<double>>& out) {
        PassMeasure sum;
        const auto pass = [&](std::uint32_t n, const PassKey& own, int sign) {
            p.reverse(view, n, own, adjoint, mean, way, sign, out);
            sum.add(p.renderer.lastPass());
        };
        if (p.options.positivize) {
            const std::uint32_t each = std::max(1u, samples / 2);
            pass(each, k, 1);
            pass(each, {k.seed, k.step, k.pass + kNegativeHalf}, -1);
            sum.reference /= 2; // each half met all derivatives
        } else {
            pass(samples, k, 0);
        }
        return sum;
    };
    PassMeasure sum;
    std::uint32_t samples = spp;
    const bool told = p.learning && p.plan.halves; // SamplingChoice and Exploration are
    if (half || told) {
        samples = (spp + 1) / 2;
        std::vector<std::vector<double>> first, second;
        sum = estimate(samples, key, first);
        sum = meanOf(sum, estimate(samples, secondHalf(key), second));
        if (told)
            p.compare(p.derivatives, way, entries(first), entries(second), sum.variance);
        addHalf(first, second, 1, gradients);
        if (half)
            addHalf(first, second, -1, *half);
        if (told)
            p.addNoise(first, second, gradients);
    } else {
        sum = estimate(spp, key, gradients);
    }
    p.sums.rays += sum.rays;
    p.concentration = sum.concentration;
    if (p.recording() && sum.paths > 0 && squares > 0) {
        p.derivatives.observe(way, sum.variance * samples / squares, double(sum.rays) / double(sum.paths), true);
        if (mean > 0)
            p.reference = sum.reference / mean;
    }
    return sum.paths;
}

std::uint64_t GuidedPasses::reverseApart(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                         std::vector<std::vector<double>>& gradients) {
    Impl& p = *impl_;
    // The roulette knows what to expect of another adjoint: split by that, some paths of this one would have thousands of copies. Its kernels are
    // there.
    const SamplingWay way = p.derivativeWay();
    PassSampling sampling = p.kernelsOf(p.recording());
    sampling.kind = way.kind;
    sampling.keepRecords = false;
    sampling.rouletteKernels |= way.roulette;
    p.renderer.setSampling(sampling);
    return p.sampledReverse(view, spp, key, adjoint, gradients);
}

void GuidedPasses::setLearning(bool on) { impl_->learning = on; }

void GuidedPasses::abandonStep() {
    impl_->images = impl_->stepStart.images;
    impl_->derivatives = impl_->stepStart.derivatives;
    impl_->exploration = impl_->stepStart.exploration;
    impl_->reference = impl_->stepStart.reference;
    impl_->sums = {};
    impl_->gating = false;
    impl_->renderer.discardRecords();
}

void GuidedPasses::endStep() {
    const ScopedTime time(impl_->seconds);
    if (!impl_->learning)
        return;
    impl_->renderer.updateGuide();
    impl_->finishStep();
    impl_->trained = true;
    ++impl_->step;
    impl_->beginStep();
}

void GuidedPasses::publish() {
    const ScopedTime time(impl_->seconds);
    impl_->renderer.publishGuide();
}

double GuidedPasses::concentration() const { return impl_->concentration; }

GuidedState GuidedPasses::state() const {
    const Impl& p = *impl_;
    return {p.stepStart.images.state(), p.stepStart.derivatives.state(), p.stepStart.exploration.state(), p.stepStart.reference, p.trained, p.step};
}

void GuidedPasses::restore(GuidedState state, std::optional<SdTree> tree) {
    Impl& p = *impl_;
    if (state.images.figures.size() != p.images.ways().size() || state.derivatives.figures.size() != p.derivatives.ways().size())
        throw Error(ErrorKind::Input, "what was learned is of other ways of sampling", "how directions are drawn, or the roulette, changed", {},
                    {"sampling", "roulette"});
    if (tree)
        p.renderer.setGuide(std::move(*tree));
    p.images.restore(std::move(state.images));
    p.derivatives.restore(std::move(state.derivatives));
    p.exploration.restore(state.exploration);
    p.reference = state.reference;
    p.trained = state.trained;
    p.step = state.step;
    p.beginStep();
}

SamplingDecision GuidedPasses::decision() const { return impl_->decide(impl_->derivatives); }
SamplingDecision GuidedPasses::imageDecision() const { return impl_->decide(impl_->images); }

double GuidedPasses::trainSeconds() const { return impl_->seconds; }

GuideRecord GuidedPasses::guideRecord() const {
    const SamplingDecision d = decision();
    GuideRecord record;
    record.figures = d.figures;
    record.rouletteFigures = d.rouletteFigures;
    record.imageFigures = imageDecision().figures;
    record.reference = impl_->reference;
    return record;
}

void GuidedPasses::load(LoadedGuide guide) {
    for (const auto& [kind, f] : guide.record.figures)
        impl_->derivatives.setFigures({kind, false}, f);
    for (const auto& [kind, f] : guide.record.rouletteFigures)
        impl_->derivatives.setFigures({kind, true}, f);
    for (const auto& [kind, f] : guide.record.imageFigures)
        impl_->images.setFigures({kind, false}, f);
    impl_->reference = guide.record.reference;
    impl_->renderer.setGuide(std::move(guide.tree));
    impl_->trained = true;
    impl_->exploration.hurry(); // who brings a guide wants it tried
    impl_->beginStep();
}

} // namespace cmpg

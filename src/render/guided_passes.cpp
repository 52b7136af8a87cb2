// Passes by the methods that were asked for or found best: learning, trials, halves, signs.
#include "render/guided_passes.h"

#include "base/error.h"
#include "base/stopwatch.h"
#include "guiding/policy/pass_differences.h"
#include "render/pass_halves.h"
#include "render/positivized_passes.h"
#include "render/roulette_gate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cmpg {
namespace {

constexpr std::uint32_t kLearningPass = 3, kGatePass = 4;

bool isImage(Renderer::Mode mode) { return mode == Renderer::Mode::Render || mode == Renderer::Mode::Difference; }

// Sum of squares, and mean over the pixels of mean_rgb |adjoint|.
struct AdjointNorms {
    double squares = 0, mean = 0;
};
AdjointNorms norms(const Image& adjoint) {
    double squares = 0, sum = 0;
    for (const float a : adjoint.values)
        if (std::isfinite(a)) {
            squares += double(a) * double(a);
            sum += std::abs(double(a));
        }
    return {squares, sum / double(std::max<std::size_t>(1, adjoint.values.size()))};
}

double raysPerPath(const PassResult& result) { return double(result.rays) / double(result.paths); }

// Two results of one pass with numbers of their own, whose variance moments of single paths put at `moments`.
void compareHalves(SamplingChoice& choice, const SamplingMethod& method, const std::vector<std::vector<double>>& a,
                   const std::vector<std::vector<double>>& b, double moments) {
    const std::optional<double> variance = PassDifferences::varianceOf(a, b);
    if (variance && moments > 0)
        choice.observeRepetition(method, *variance / moments);
}

} // namespace

struct GuidedPasses::Impl {
    Renderer& renderer;
    GuidedOptions options;
    SamplingPolicy policy;
    double seconds = 0, concentration = 0;

    Impl(Renderer& r, const GuidedOptions& o) : renderer(r), options(o), policy(o.sampling, o.roulette, o.immediate) {}

    // The steps that learn share their kernels, whatever the methods that they try.
    PassPlan planOf(const SamplingMethod& method, bool record) const {
        const bool shared = record && policy.learning;
        return {.method = method, .record = record, .guidedKernels = shared && policy.mayGuide(), .rouletteKernels = shared && policy.mayRoulette()};
    }

    PassPlan reversePlan(const SamplingMethod& method, int sign, double meanAdjoint) const {
        PassPlan plan = planOf(method, policy.recording());
        plan.sign = sign;
        plan.reference = policy.reference * meanAdjoint;
        return plan;
    }

    // Of the next pass of a mode.
    PassPlan nextPlan(Renderer::Mode mode) const {
        const bool image = isImage(mode);
        SamplingMethod method = image ? policy.imageMethod() : policy.derivativeMethod();
        method.roulette &= mode == Renderer::Mode::Reverse;
        PassPlan plan = planOf(method, policy.recording());
        plan.sign = options.positivize && !image;
        return plan;
    }

    // Records and measures one pass of any mode, then rebuilds. `run` takes its plan, fills in its result and returns its estimate, entry by entry.
    // `mean` has SamplingChoice::observeMean()'s of a result and its estimate, in the units of the result's root variance.
    template <class Pass, class Mean>
    PassResult learn(SamplingChoice& choice, std::uint32_t spp, std::uint32_t pass, double adjointSquares, Pass&& run, Mean&& mean) {
        std::vector<SamplingMethod> methods;
        for (const SamplingMethod& m : choice.methods())
            if (!m.roulette)
                methods.push_back(m);
        const SamplingMethod method = methods[pass % methods.size()];
        PassResult result;
        const std::vector<double> estimate = run(planOf(method, true), result);
        if (adjointSquares > 0 && result.paths > 0) {
            const double unit = spp / adjointSquares;
            choice.observe(method, result.variance * unit, raysPerPath(result));
            choice.observeResult(method, estimate, unit);
            choice.observeMean(method, mean(result, estimate) / std::sqrt(adjointSquares), spp);
        }
        renderer.updateGuide(false);
        renderer.publishGuide();
        policy.beginStep();
        return result;
    }

    PassResult reverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients,
                       const PassPlan& plan, FirstVertices* firstVertices = nullptr) {
        PixelSamples samples;
        if (options.pixels == PixelSampling::Adjoint)
            samples = sampleCounts(adjoint, spp, key);
        return renderer.reverse(view, spp, key, adjoint, samples.counts, samples.weights, gradients, plan, firstVertices);
    }

    // Learned from, if steps learn. `half`: as in reverseHalves(); null: whole, unless the halves are to tell something. `whole`: not a part alone.
    std::uint64_t learnedReverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint, std::vector<std::vector<double>>& gradients,
                                 std::vector<std::vector<double>>* half, bool whole = true);

    // Variance and rays with and without roulette, as the measured pass will run: pixel sampling included. In the units of the learning
    // passes, which ran without either.
    void gate(const View& view, std::uint32_t spp, std::uint64_t seed, const Image& adjoint, double meanAdjoint) {
        if (!options.roulette || !(policy.reference > 0))
            return;
        const Sampling kind = policy.derivatives.bestKind();
        const auto gain = measureRoulette([&](std::uint32_t pass, bool roulette, std::vector<std::vector<double>>& gradients) {
            PassPlan plan = reversePlan({kind, roulette}, 0, meanAdjoint);
            plan.measure = true;
            return reverse(view, spp, {seed, pass, kGatePass}, adjoint, gradients, plan);
        });
        if (gain)
            policy.derivatives.observeRoulette(kind, gain->variance, gain->rays);
    }
};

GuidedPasses::GuidedPasses(Renderer& renderer, const GuidedOptions& options) : impl_(std::make_unique<Impl>(renderer, options)) {}
GuidedPasses::~GuidedPasses() = default;

void GuidedPasses::prepare(std::initializer_list<Renderer::Mode> modes) {
    for (const Renderer::Mode mode : modes) {
        if (impl_->policy.learning) { // steps that learn, and others
            impl_->renderer.prepare(mode, impl_->planOf({}, true));
            impl_->renderer.prepare(mode, PassPlan{});
            continue;
        }
        for (const SamplingMethod& method : (isImage(mode) ? impl_->policy.images : impl_->policy.derivatives).methods())
            if (!method.roulette || mode == Renderer::Mode::Reverse)
                impl_->renderer.prepare(mode, {.method = method}, false, true);
    }
}

void GuidedPasses::prepareNext(Renderer::Mode mode, bool layers) { impl_->renderer.prepare(mode, impl_->nextPlan(mode), layers); }

void GuidedPasses::prepareAhead(std::initializer_list<Renderer::Mode> modes) {
    std::vector<std::pair<Renderer::Mode, PassPlan>> passes;
    for (const Renderer::Mode mode : modes)
        passes.emplace_back(mode, impl_->nextPlan(mode));
    impl_->renderer.prepareAhead(passes);
}

std::uint32_t GuidedPasses::unprepared(std::initializer_list<Renderer::Mode> modes) const {
    return std::uint32_t(std::ranges::count_if(modes, [&](Renderer::Mode mode) { return !impl_->renderer.isPrepared(mode, impl_->nextPlan(mode)); }));
}

void GuidedPasses::trainRender(const View& view, std::uint32_t spp, std::uint32_t passes, std::uint64_t seed, std::uint32_t first) {
    const ScopedTime time(impl_->seconds);
    Impl& p = *impl_;
    for (std::uint32_t i = first; i < first + passes; ++i)
        p.learn(
            p.policy.images, spp, i, 1,
            [&](const PassPlan& plan, PassResult& result) { return entries(p.renderer.render(view, spp, {seed, i, kLearningPass}, plan, &result)); },
            // Variances are means over the channels.
            [](const PassResult&, std::span<const double> estimate) { return std::accumulate(estimate.begin(), estimate.end(), 0.0) / 3; });
    if (passes > 0)
        p.policy.setTrained();
}

void GuidedPasses::trainForward(const View& view, std::uint32_t spp, std::uint32_t passes, std::uint64_t seed,
                                std::span<const std::uint32_t> parameters, std::span<const std::vector<float>> directions, std::uint32_t first) {
    const ScopedTime time(impl_->seconds);
    Impl& p = *impl_;
    for (std::uint32_t i = first; i < first + passes; ++i)
        p.learn(
            p.policy.derivatives, spp, i, 1,
            [&](const PassPlan& plan, PassResult& result) {
                return entries(p.renderer.forward(view, spp, {seed, i, kLearningPass}, parameters, directions, plan, &result));
            },
            [](const PassResult&, std::span<const double>) { return 0.0; }); // signs cancel
    if (passes > 0)
        p.policy.setTrained();
}

void GuidedPasses::trainReverse(const View& view, std::uint32_t spp, std::uint32_t passes, std::uint64_t seed, const Image& adjoint) {
    const ScopedTime time(impl_->seconds);
    Impl& p = *impl_;
    const AdjointNorms norm = norms(adjoint);
    for (std::uint32_t i = 0; i < passes; ++i) {
        const PassResult last = p.learn(
            p.policy.derivatives, spp, i, norm.squares,
            [&](const PassPlan& plan, PassResult& result) {
                std::vector<std::vector<double>> gradients;
                result = p.renderer.reverse(view, spp, {seed, i, kLearningPass}, adjoint, {}, {}, gradients, plan);
                return entries(gradients);
            },
            // The reference is a mean over the channels; variances are sums over them.
            [&](const PassResult& result, std::span<const double>) { return std::sqrt(3.0) * double(adjoint.pixels()) * result.reference; });
        if (norm.mean > 0)
            p.policy.reference = last.reference / norm.mean;
    }
    if (passes == 0)
        return;
    p.gate(view, spp, seed, adjoint, norm.mean);
    p.policy.setTrained();
}

Image GuidedPasses::render(const View& view, std::uint32_t spp, const PassKey& key, Layers* layers) {
    Impl& p = *impl_;
    const SamplingMethod method = p.policy.imageMethod();
    PassResult result;
    Image image = p.renderer.render(view, spp, key, p.planOf(method, p.policy.recording()), &result, layers);
    p.policy.addRays(result.rays);
    if (p.policy.recording() && result.paths > 0)
        p.policy.images.observe(method, result.variance * spp, raysPerPath(result));
    return image;
}

ImageHalves GuidedPasses::renderHalves(const View& view, std::uint32_t spp, const PassKey& key, bool difference, const SampleRanges& samples) {
    Impl& p = *impl_;
    const SamplingMethod method = p.policy.imageMethod();
    const PassPlan plan = p.planOf(method, p.policy.recording());
    const std::span<const std::uint32_t> counts = samples.counts;
    ImageHalves halves{{}, counts.empty() ? std::max(1u, spp / 2) : *std::max_element(counts.begin(), counts.end()), {counts.begin(), counts.end()}};
    PassResult sum;
    for (std::uint32_t h = 0; h < 2; ++h) {
        const PassKey own = h == 0 ? key : secondHalf(key);
        PassResult result;
        if (difference)
            halves.half[h] = p.renderer.renderDifference(view, halves.samples, own, samples, plan, &result);
        else
            halves.half[h].image = p.renderer.render(view, halves.samples, own, plan, &result);
        sum.add(result);
    }
    p.policy.addRays(sum.rays);
    if (p.policy.recording() && sum.paths > 0) {
        const PassDifferences::Pair pair = PassDifferences::compare(entries(halves.half[0].image), entries(halves.half[1].image));
        const double variance = pair.variance * std::max(1u, spp / 2);
        if (pair.telling)
            p.policy.images.observe(method, variance, raysPerPath(sum));
        else
            p.policy.images.observeRough(method, variance, raysPerPath(sum));
    }
    return halves;
}

Sampling GuidedPasses::imageMethod() const { return impl_->policy.imageMethod().kind; }

double GuidedPasses::imageVariance(Sampling method) const {
    const SamplingChoice& images = impl_->policy.images;
    for (std::size_t i = 0; i < images.methods().size(); ++i)
        if (images.methods()[i] == SamplingMethod{method, false} && images.figures(i).passes > 0)
            return images.figures(i).variance;
    return 0;
}

Image GuidedPasses::forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                            std::span<const std::vector<float>> directions, Layers* layers) {
    const SamplingMethod method{impl_->policy.derivativeMethod().kind, false};
    PassPlan plan = impl_->planOf(method, impl_->policy.recording());
    if (!impl_->options.positivize)
        return impl_->renderer.forward(view, spp, key, parameters, directions, plan, nullptr, layers);
    return positivizedImage(spp, key, [&](std::uint32_t samples, const PassKey& own, int sign) {
        plan.sign = sign;
        return impl_->renderer.forward(view, samples, own, parameters, directions, plan);
    });
}

Image GuidedPasses::picture(const View& view, std::uint32_t spp, const PassKey& key, bool difference) {
    const Renderer::Mode mode = difference ? Renderer::Mode::Difference : Renderer::Mode::Render;
    PassPlan plan{.method = impl_->policy.settledMethod(impl_->policy.images)};
    if (impl_->policy.recording() && !impl_->renderer.isPrepared(mode, plan)) // others would have to be compiled
        plan = impl_->planOf(plan.method, true);
    plan.keepRecords = false;
    return difference ? impl_->renderer.renderDifference(view, spp, key, {}, plan).image : impl_->renderer.render(view, spp, key, plan);
}

void GuidedPasses::picture(const View& view, std::uint32_t spp, const PassKey& key, bool difference, Film& film) {
    if (!difference)
        return render(view, spp, key, film);
    impl_->renderer.renderDifference(view, spp, key, film, impl_->planOf(impl_->policy.settledMethod(impl_->policy.images), false));
}

void GuidedPasses::render(const View& view, std::uint32_t spp, const PassKey& key, Film& film) {
    impl_->renderer.render(view, spp, key, film, impl_->planOf(impl_->policy.settledMethod(impl_->policy.images), false));
}

void GuidedPasses::forward(const View& view, std::uint32_t spp, const PassKey& key, std::span<const std::uint32_t> parameters,
                           std::span<const std::vector<float>> directions, Film& film) {
    impl_->renderer.forward(view, spp, key, parameters, directions, film, impl_->planOf(impl_->policy.settledMethod(impl_->policy.derivatives), false));
}

std::uint64_t GuidedPasses::reverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                    std::vector<std::vector<double>>& gradients) {
    return impl_->learnedReverse(view, spp, key, adjoint, gradients, nullptr);
}

std::uint64_t GuidedPasses::reverseHalves(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                          std::vector<std::vector<double>>& gradients, std::vector<std::vector<double>>& half) {
    return impl_->learnedReverse(view, spp, key, adjoint, gradients, &half);
}

std::uint64_t GuidedPasses::reversePart(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                        std::vector<std::vector<double>>& gradients) {
    return impl_->learnedReverse(view, spp, key, adjoint, gradients, nullptr, false);
}

void GuidedPasses::tellNoise(const std::vector<std::vector<double>>& half, const std::vector<std::vector<double>>& sum) {
    if (impl_->policy.tellsNoise())
        impl_->policy.noise.add(half, sum);
}

std::uint64_t GuidedPasses::Impl::learnedReverse(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                                 std::vector<std::vector<double>>& gradients, std::vector<std::vector<double>>* half, bool whole) {
    const SamplingMethod method = policy.derivativeMethod();
    const AdjointNorms norm = norms(adjoint);
    const auto estimate = [&](std::uint32_t samples, const PassKey& own, std::vector<std::vector<double>>& out) {
        const auto pass = [&](std::uint32_t n, const PassKey& k, int sign) {
            return reverse(view, n, k, adjoint, out, reversePlan(method, sign, norm.mean));
        };
        return options.positivize ? positivizedGradient(samples, own, pass) : pass(samples, own, 0);
    };
    PassResult sum;
    std::uint32_t samples = spp;
    if (half || policy.tellsNoise()) {
        samples = (spp + 1) / 2;
        std::vector<std::vector<double>> first, second;
        sum = estimate(samples, key, first);
        sum = meanOf(sum, estimate(samples, secondHalf({key.seed, key.step, key.pass}), second));
        if (policy.tellsNoise())
            compareHalves(policy.derivatives, method, first, second, sum.variance);
        addHalf(first, second, 1, gradients);
        if (half)
            addHalf(first, second, -1, *half);
        if (whole && policy.tellsNoise()) {
            std::vector<std::vector<double>> error;
            for (const auto& entries : first)
                error.emplace_back(entries.size());
            addHalf(first, second, -1, error);
            policy.noise.add(error, gradients);
        }
    } else {
        sum = estimate(spp, key, gradients);
    }
    policy.addRays(sum.rays);
    concentration = sum.concentration;
    if (policy.recording() && sum.paths > 0 && norm.squares > 0) {
        policy.derivatives.observe(method, sum.variance * samples / norm.squares, raysPerPath(sum), true);
        if (norm.mean > 0)
            policy.reference = sum.reference / norm.mean;
    }
    return sum.paths;
}

std::uint64_t GuidedPasses::reverseApart(const View& view, std::uint32_t spp, const PassKey& key, const Image& adjoint,
                                         std::vector<std::vector<double>>& gradients, FirstVertices* firstVertices) {
    // The roulette knows what to expect of another adjoint: split by that, some paths of this one would have thousands of copies. Its kernels are
    // there.
    const SamplingMethod method = impl_->policy.derivativeMethod();
    PassPlan plan = impl_->planOf({method.kind, false}, impl_->policy.recording());
    plan.keepRecords = false;
    plan.rouletteKernels |= method.roulette;
    return impl_->reverse(view, spp, key, adjoint, gradients, plan, firstVertices).paths;
}

void GuidedPasses::setLearning(bool on) { impl_->policy.learning = on; }

bool GuidedPasses::learning() const { return impl_->policy.learning; }

void GuidedPasses::abandonStep() {
    impl_->policy.abandonStep();
    impl_->renderer.discardRecords();
}

void GuidedPasses::endStep() {
    const ScopedTime time(impl_->seconds);
    if (!impl_->policy.learning)
        return;
    impl_->renderer.updateGuide();
    impl_->policy.endStep();
}

void GuidedPasses::publish() {
    const ScopedTime time(impl_->seconds);
    impl_->renderer.publishGuide();
}

double GuidedPasses::concentration() const { return impl_->concentration; }

GuidedState GuidedPasses::state() const { return impl_->policy.state(); }

void GuidedPasses::restore(GuidedState state, std::optional<SdTree> tree) {
    if (!impl_->policy.fits(state))
        throw Error(ErrorKind::Input, "what was learned is of other methods of sampling", "how directions are drawn, or the roulette, changed", {},
                    {"sampling", "roulette"});
    if (tree)
        impl_->renderer.setGuide(std::move(*tree));
    impl_->policy.restore(std::move(state));
}

SamplingDecision GuidedPasses::decision() const { return impl_->policy.decide(impl_->policy.derivatives); }
SamplingDecision GuidedPasses::imageDecision() const { return impl_->policy.decide(impl_->policy.images); }

double GuidedPasses::trainSeconds() const { return impl_->seconds; }

GuideContext GuidedPasses::guideContext() const {
    const SamplingDecision d = decision();
    GuideContext context;
    context.figures = d.figures;
    context.rouletteFigures = d.rouletteFigures;
    context.imageFigures = imageDecision().figures;
    context.reference = impl_->policy.reference;
    return context;
}

void GuidedPasses::load(LoadedGuide guide) {
    SamplingPolicy& policy = impl_->policy;
    for (const auto& [kind, f] : guide.context.figures)
        policy.derivatives.setFigures({kind, false}, f);
    for (const auto& [kind, f] : guide.context.rouletteFigures)
        policy.derivatives.setFigures({kind, true}, f);
    for (const auto& [kind, f] : guide.context.imageFigures)
        policy.images.setFigures({kind, false}, f);
    policy.reference = guide.context.reference;
    impl_->renderer.setGuide(std::move(guide.tree));
    policy.trust();
}

} // namespace cmpg

// What a session does with a scene: settings, the renderer they need, films that refine.
#include "live/live_work.h"

#include "imaging/parameter_image.h"
#include "live/guide_pick.h"
#include "session/render_options.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace cmpg {
namespace {

constexpr double kSubmissionSeconds = 0.02;

bool sameCamera(const Camera& a, const Camera& b) {
    return a.toWorld == b.toWorld && a.orthographic == b.orthographic && a.yfov == b.yfov && a.ymag == b.ymag;
}

} // namespace

LiveWork::LiveWork(const Options& options, Device& device, LoadedScene& scene, LiveState& state, Hooks hooks)
    : options_(options), device_(device), scene_(scene), state_(state), hooks_(std::move(hooks)) {}

LiveWork::~LiveWork() = default;

LiveSettings LiveWork::sanitised(LiveSettings s) const {
    const auto finite = [](float v, float low, float high, float otherwise) { return std::isfinite(v) ? std::clamp(v, low, high) : otherwise; };
    s.width = std::clamp(s.width, 1, 8192);
    s.height = std::clamp(s.height, 1, 8192);
    s.spp = std::clamp(s.spp, 1u, 1u << 16);
    s.sppGradient = std::clamp(s.sppGradient, 1u, 1u << 16);
    s.sppLimit = std::clamp(s.sppLimit, 1u, 1u << 24);
    s.rateFactor = finite(s.rateFactor, 0, 1e6f, 1);
    s.view = std::min(s.view, std::uint32_t(std::max<std::size_t>(scene_.views(), 1) - 1));
    s.camera.yfov = finite(s.camera.yfov, 1e-3f, 3.1f, 0.8f);
    s.camera.ymag = finite(s.camera.ymag, 1e-6f, 1e6f, 1);
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!std::isfinite(s.camera.toWorld[column][row]))
                s.camera.toWorld = scene_.info->cameras.front().toWorld;
    std::vector<std::uint32_t> known;
    for (const std::uint32_t p : s.parameters)
        if (p < scene_.scene.parameters.size() && std::find(known.begin(), known.end(), p) == known.end())
            known.push_back(p);
    s.parameters = std::move(known);
    return s;
}

bool LiveWork::outdates(const LiveSettings& wished) const {
    const LiveSettings& s = settings_;
    if (wished.mode != s.mode || (s.mode != LiveMode::Render && wished.parameters != s.parameters))
        return true;
    if (optimizing())
        return false; // a step is worth finishing
    const bool moved = wished.width != s.width || wished.height != s.height || !sameCamera(wished.camera, s.camera);
    return (moved && !previewing_) || wished.layers != s.layers || wished.sampling != s.sampling || wished.running != s.running;
}

void LiveWork::setSettings(const LiveSettings& wished) {
    const LiveSettings s = std::exchange(settings_, wished);
    const LiveSettings& w = settings_;
    const bool first = directions_.empty();
    const bool otherParameters = first || w.parameters != s.parameters;
    if (otherParameters) {
        scene_.differentiate(w.parameters);
        directions_.clear();
        for (const std::uint32_t p : w.parameters)
            directions_.emplace_back(scene_.scene.parameters[p].entries(), 1.0f);
        show(LivePicture::ParameterGradient, nullptr);
        showParameter();
    }
    const bool otherMode = w.mode != s.mode;
    const bool otherView = w.view != s.view || otherMode;
    const bool moved = w.width != s.width || w.height != s.height || !sameCamera(w.camera, s.camera);
    if (otherParameters || otherView || (moved && !optimizing()) || w.layers != s.layers || w.sampling != s.sampling) {
        if (otherParameters || otherMode)
            show(LivePicture::Gradient, nullptr);
        if (otherView && optimizing())
            show(LivePicture::Image, nullptr);
        if (!w.layers)
            for (const LivePicture p : {LivePicture::Normal, LivePicture::Depth, LivePicture::Albedo, LivePicture::Guided, LivePicture::Cells})
                show(p, nullptr);
        restartFilms();
    }
    if (!optimizing())
        for (const LivePicture p : {LivePicture::Target, LivePicture::Difference})
            show(p, nullptr);
    else if (!state_.picture(LivePicture::Target) || otherView)
        show(LivePicture::Target, std::make_shared<const Image>(scene_.targets[w.view].image));
    state_.settings = w;
    updateGuideFigures();
}

void LiveWork::targetsChanged() {
    dropOptimization(false);
    settings_ = sanitised(settings_); // the view may be gone
    state_.views = std::uint32_t(scene_.views());
    state_.targets.clear();
    for (const Target& t : scene_.targets)
        state_.targets.push_back(t.name);
    for (const LivePicture p : {LivePicture::Target, LivePicture::Difference, LivePicture::ParameterGradient})
        show(p, nullptr);
    if (optimizing())
        show(LivePicture::Target, std::make_shared<const Image>(scene_.targets[settings_.view].image));
    restartFilms();
}

void LiveWork::reset(std::optional<float> fill) {
    scene_.restore();
    if (fill)
        scene_.fill(settings_.parameters, *fill);
    steps_ = 0;
    training_ = 0;
    dropOptimization(false);
    const std::vector<std::uint32_t> touched = scene_.remembered();
    const bool reachable = std::all_of(touched.begin(), touched.end(), [&](std::uint32_t p) {
        return std::find(builtFor_.begin(), builtFor_.end(), p) != builtFor_.end();
    });
    if (run_ && reachable) {
        for (const std::uint32_t p : touched)
            run_->renderer().setParameter(p, scene_.scene.parameters[p].values);
        run_->setGuided(guidedOptions(), false);
        drawnBy_ = settings_.sampling;
        trained_ = 0;
    } else {
        dropRun();
    }
    show(LivePicture::ParameterGradient, nullptr);
    show(LivePicture::Gradient, nullptr);
    showParameter();
    restartFilms();
}

bool LiveWork::unfinished(const Refined& r) const { return r.film.pixels.empty() || r.film.samples < settings_.sppLimit; }

bool LiveWork::hasWork() const {
    if (optimizing())
        return settings_.running || steps_ > 0 || unfinished(image_) || unfinished(gradient_);
    return training_ > 0 || (settings_.running && (unfinished(image_) || (differentiating() && unfinished(gradient_))));
}

std::string LiveWork::missing() const {
    if (settings_.mode == LiveMode::Render)
        return "";
    if (settings_.parameters.empty())
        return "select a parameter";
    if (settings_.mode == LiveMode::Optimize && scene_.views() == 0)
        return "drop a target image here, or use the image as target";
    return "";
}

void LiveWork::work() {
    ensureRun();
    if (optimizing() && (settings_.running || steps_ > 0))
        return step();
    if (training_ > 0 && !optimizing())
        return train();
    // The image is there to find one's way, the gradient image is what the mode is about.
    constexpr std::uint32_t kImageShare = 4;
    const bool gradientDue = differentiating() && unfinished(gradient_) &&
                             (!unfinished(image_) || (image_.film.samples > 0 && gradient_.film.samples < kImageShare * image_.film.samples));
    refine(gradientDue ? gradient_ : image_, gradientDue);
}

void LiveWork::recover() {
    previewing_ = false;
    if (!run_)
        return;
    run_->passes().setLearning(false);
    run_->passes().abandonStep();
}

View LiveWork::view() const {
    if (optimizing())
        return scene_.view(settings_.view);
    return {&settings_.camera, settings_.width, settings_.height};
}

SamplingDecision LiveWork::decision() const {
    if (!run_)
        return {};
    return settings_.mode == LiveMode::Render ? run_->passes().imageDecision() : run_->passes().decision();
}

GuidedOptions LiveWork::guidedOptions() const {
    GuidedOptions guided = cmpg::guidedOptions(options_);
    guided.sampling = settings_.sampling;
    return guided;
}

void LiveWork::ensureRun() {
    if (run_ && (settings_.mode == LiveMode::Render || builtFor_ == settings_.parameters)) {
        if (drawnBy_ == settings_.sampling)
            return;
        dropOptimization(true);
        run_->setGuided(guidedOptions(), true);
        drawnBy_ = settings_.sampling;
        return;
    }
    dropRun();
    hooks_.busyWith("preparing the scene");
    RenderConfig config = renderConfig(options_, scene_.scene, settings_.parameters);
    config.guiding = true;
    config.differences = options_.recovery.sppDifference > 0 && !settings_.parameters.empty();
    run_.emplace(device_, scene_.scene, config, guidedOptions());
    run_->renderer().setInteraction({.submissionSeconds = kSubmissionSeconds,
                                     .beforeSubmission = hooks_.betweenSubmissions,
                                     .compiling = [this](bool begins) { hooks_.busyWith(begins ? "compiling kernels" : ""); }});
    builtFor_ = settings_.parameters;
    drawnBy_ = settings_.sampling;
    hooks_.busyWith("");
}

void LiveWork::dropRun() {
    dropOptimization(true);
    run_.reset();
    trained_ = 0;
    drawnBefore_ = guidedBefore_ = 0;
}

void LiveWork::restartFilms() {
    const View v = view();
    image_.film = Film(v.width, v.height, settings_.layers);
    gradient_.film = Film(v.width, v.height);
    fadingSteps_ = 0;
    state_.imageSamples = state_.gradientSamples = 0;
    if (run_) {
        drawnBefore_ = guidedBefore_ = 0;
        for (const GuidedDepth& d : run_->renderer().statistics().guided) {
            drawnBefore_ += d.drawn;
            guidedBefore_ += d.guided;
        }
    }
}

void LiveWork::expose(const View& v, std::uint32_t spp, Film& film, bool forward) {
    const PassKey key = forward ? PassKey{.seed = options_.seed, .pass = 1} : optimizing() ? pictureKey(options_.seed, settings_.view) : PassKey{.seed = options_.seed};
    if (forward)
        run_->passes().forward(v, spp, key, settings_.parameters, directions_, film);
    else
        run_->passes().render(v, spp, key, film);
}

bool LiveWork::previewed(Refined& r, bool forward) {
    const int divisor = r.previewDivisor();
    if (r.film.samples > 0 || divisor == 1 || optimizing())
        return false;
    previewing_ = true;
    View small = view();
    small.width = std::max(1, small.width / divisor);
    small.height = std::max(1, small.height / divisor);
    Film film(small.width, small.height);
    expose(small, 1, film, forward);
    previewing_ = false;
    state_.preview = true;
    auto image = std::make_shared<const Image>(film.image());
    show(forward ? LivePicture::Gradient : LivePicture::Image, std::move(image));
    hooks_.publish();
    hooks_.betweenSubmissions(); // the view may have changed again
    return true;
}

void LiveWork::refine(Refined& r, bool forward) {
    previewed(r, forward);
    const std::uint32_t spp = r.nextSamples(settings_.sppLimit);
    const double compiled = device_.compileSeconds();
    const auto start = std::chrono::steady_clock::now();
    expose(view(), spp, r.film, forward);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    const double paths = double(spp) * double(r.film.pixels.size());
    r.pathsPerSecond = paths / std::max(1e-6, taken.count() - (device_.compileSeconds() - compiled));
    state_.samplesPerSecond = r.pathsPerSecond;
    state_.preview = false;
    if (!forward)
        showLayers(r.film);
    // After a step there is an image already that had more samples, of almost the same parameters.
    std::uint32_t& shown = forward ? state_.gradientSamples : state_.imageSamples;
    if (r.film.samples >= shown) {
        shown = r.film.samples;
        if (forward) {
            state_.gradientFading = false;
            show(LivePicture::Gradient, std::make_shared<const Image>(r.film.image()));
        } else {
            showImage(r.film.image());
        }
    }
    updateGuideFigures();
}

void LiveWork::train() {
    const View v = view();
    if (settings_.mode == LiveMode::Gradient && !settings_.parameters.empty())
        run_->passes().trainForward(v, settings_.spp, 1, options_.seed, settings_.parameters, directions_, trained_);
    else
        run_->passes().trainRender(v, settings_.spp, 1, options_.seed, trained_);
    --training_;
    ++trained_;
    restartFilms();
    updateGuideFigures();
}

void LiveWork::show(LivePicture picture, std::shared_ptr<const Image> image) {
    state_.pictures[std::size_t(picture)] = std::move(image);
    if (picture == LivePicture::Image && !state_.picture(picture))
        state_.imageSamples = 0;
    if (picture == LivePicture::Gradient && !state_.picture(picture))
        state_.gradientSamples = 0;
}

void LiveWork::showImage(Image image) {
    if (optimizing()) {
        Image difference = image;
        const std::vector<float>& target = scene_.targets[settings_.view].image.values;
        for (std::size_t i = 0; i < target.size(); ++i)
            difference.values[i] -= target[i];
        show(LivePicture::Difference, std::make_shared<const Image>(std::move(difference)));
    }
    show(LivePicture::Image, std::make_shared<const Image>(std::move(image)));
}

void LiveWork::showLayers(const Film& film) {
    if (!film.hasLayers())
        return;
    Layers layers = film.layers();
    show(LivePicture::Cells, guide() ? std::make_shared<const Image>(cellPicture(*guide(), view(), layers.depth)) : nullptr);
    show(LivePicture::Normal, std::make_shared<const Image>(std::move(layers.normal)));
    show(LivePicture::Depth, std::make_shared<const Image>(std::move(layers.depth)));
    show(LivePicture::Albedo, std::make_shared<const Image>(std::move(layers.albedo)));
    show(LivePicture::Guided, std::make_shared<const Image>(std::move(layers.guided)));
}

void LiveWork::showParameter() {
    if (settings_.parameters.empty())
        return show(LivePicture::Parameter, nullptr);
    const Parameter& p = scene_.scene.parameters[settings_.parameters.front()];
    show(LivePicture::Parameter, std::make_shared<const Image>(parameterImage(p, p.values)));
}

void LiveWork::updateGuideFigures() {
    state_.guideLearned = guide() != nullptr;
    state_.guideCells = guide() ? std::uint32_t(guide()->cells().size()) : 0;
    state_.guidePasses = guide() ? guide()->updates() : 0;
    const SamplingDecision d = decision();
    state_.sampling = d.method.kind;
    state_.roulette = d.method.roulette;
    std::uint64_t drawn = 0, guided = 0;
    if (run_)
        for (const GuidedDepth& depth : run_->renderer().statistics().guided) {
            drawn += depth.drawn;
            guided += depth.guided;
        }
    state_.guidedShare = drawn > drawnBefore_ ? double(guided - guidedBefore_) / double(drawn - drawnBefore_) : 0;
}

} // namespace cmpg

// What a session does with a scene: settings, the renderer they need, films that refine.
#include "live/live_work.h"

#include "imaging/parameter_image.h"
#include "session/library_options.h"

#include <algorithm>
#include <cmath>

namespace cmpg {
namespace {

constexpr double kSubmissionSeconds = 0.02; // a click is answered, and a pass of no more use ended, within a moment

bool sameCamera(const v1::CameraInfo& a, const v1::CameraInfo& b) {
    return a.toWorld == b.toWorld && a.orthographic == b.orthographic && a.yfov == b.yfov && a.ymag == b.ymag;
}

} // namespace

LiveWork::LiveWork(const Options& options, const v1::Device& device, LoadedScene& scene, LiveState& state, Hooks hooks)
    : options_(options), device_(device), scene_(scene), state_(state), hooks_(std::move(hooks)) {}

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
    if (!std::all_of(s.camera.toWorld.begin(), s.camera.toWorld.end(), [](float v) { return std::isfinite(v); }))
        s.camera.toWorld = scene_.info->cameras.front().toWorld;
    std::vector<std::uint32_t> known;
    for (const std::uint32_t p : s.parameters)
        if (p < scene_.info->parameters.size() && std::find(known.begin(), known.end(), p) == known.end())
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
    const bool first = !std::exchange(applied_, true);
    const bool otherParameters = first || w.parameters != s.parameters;
    if (otherParameters) {
        scene_.remember(w.parameters);
        directions_.clear();
        for (const std::uint32_t p : w.parameters)
            directions_.push_back({scene_.parameter(p).name, std::vector<float>(scene_.parameter(p).entries(), 1.0f)});
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
        const std::uint32_t carried = state_.imageCarried && optimizing() && !otherView ? state_.imageSamples : 0;
        restartFilms();
        if (carried > 0) { // nothing of this changes what it shows
            state_.imageSamples = carried;
            state_.imageCarried = true;
        }
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
    dropRecovery(false);
    settings_ = sanitised(settings_); // the view may be gone
    state_.views = std::uint32_t(scene_.views());
    state_.targets.clear();
    for (const v1::Target& t : scene_.targets)
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
    dropRecovery(false);
    const std::vector<std::uint32_t> touched = scene_.remembered();
    const bool reachable = std::all_of(touched.begin(), touched.end(), [&](std::uint32_t p) {
        return std::find(builtFor_.begin(), builtFor_.end(), p) != builtFor_.end();
    });
    if (renderer_ && reachable)
        renderer_->forget();
    else
        dropRenderer(); // kernels are made for the values of the others
    show(LivePicture::ParameterGradient, nullptr);
    show(LivePicture::Gradient, nullptr);
    showParameter();
    restartFilms();
}

bool LiveWork::unfinished(const Refined& r) const { return r.film.pixels() == 0 || r.film.samples() < settings_.sppLimit; }

bool LiveWork::hasWork() const {
    if (optimizing())
        return settings_.running || steps_ > 0 || unfinished(image_) || unfinished(gradient_);
    return training_ > 0 || (settings_.running && (unfinished(image_) || (differentiating() && unfinished(gradient_))));
}

std::string LiveWork::missing() const {
    if (settings_.mode != LiveMode::Render && settings_.parameters.empty())
        return "select a parameter";
    if (settings_.mode == LiveMode::Optimize && scene_.views() == 0)
        return "drop a target image here, or use the image as target";
    if (!settings_.running && !optimizing() && image_.film.samples() == 0)
        return "paused before the first sample of this view";
    return "";
}

void LiveWork::work() {
    ensureRenderer();
    if (optimizing() && (settings_.running || steps_ > 0))
        return step();
    if (training_ > 0 && !optimizing())
        return train();
    // The image is there to find one's way, the gradient image is what the mode is about.
    constexpr std::uint32_t kImageShare = 4;
    const bool gradientDue = differentiating() && unfinished(gradient_) &&
                             (!unfinished(image_) || (image_.film.samples() > 0 && gradient_.film.samples() < kImageShare * image_.film.samples()));
    refine(gradientDue ? gradient_ : image_, gradientDue);
}

void LiveWork::leaveDevice() {
    dropRenderer();
    device_.reset();
    restartFilms();
}

LiveWork::Seen LiveWork::seen() const {
    if (!optimizing())
        return {settings_.camera, settings_.width, settings_.height};
    const v1::Target& target = scene_.targets[settings_.view];
    return {*target.from, target.image.width, target.image.height};
}

v1::PassReport LiveWork::report() const {
    if (!renderer_)
        return {};
    return renderer_->report(settings_.mode == LiveMode::Render ? v1::PassKind::Render : v1::PassKind::Backward);
}

v1::PassOptions LiveWork::pass(std::uint32_t spp, std::uint32_t frame) const {
    return {.from = seen().camera, .spp = spp, .seed = options_.seed, .frame = frame, .strict = false};
}

void LiveWork::ensureRenderer() {
    if (renderer_ && (settings_.mode == LiveMode::Render || builtFor_ == settings_.parameters)) {
        if (drawnBy_ == settings_.sampling)
            return;
        dropRecovery(true);
        renderer_->setSampling(settings_.sampling);
        drawnBy_ = settings_.sampling;
        return;
    }
    dropRenderer();
    hooks_.busyWith("preparing the scene");
    v1::PathOptions paths = pathOptions(options_, options_.effectiveDepth(scene_.scene.maxDepth()));
    paths.sampling = settings_.sampling;
    paths.guide.load.clear(); // a session learns its own
    renderer_.emplace(*device_, scene_.scene, v1::RendererOptions{.paths = paths, .parameters = scene_.names(settings_.parameters), .recoveries = true});
    renderer_->onSubmission(hooks_.betweenSubmissions, kSubmissionSeconds);
    renderer_->onCompile([this](bool begins) { hooks_.busyWith(begins ? "compiling kernels" : ""); });
    renderer_->prepare({});
    builtFor_ = settings_.parameters;
    drawnBy_ = settings_.sampling;
    hooks_.busyWith("");
}

void LiveWork::dropRenderer() {
    dropRecovery(true);
    renderer_.reset();
    drawnBefore_ = guidedBefore_ = 0;
}

void LiveWork::restartFilms() {
    const Seen s = seen();
    image_.film = v1::Film(s.width, s.height, settings_.layers);
    gradient_.film = v1::Film(s.width, s.height);
    fadingSteps_ = 0;
    state_.imageSamples = state_.gradientSamples = 0;
    state_.imageCarried = false;
    earlierSamples_ = 0;
    drawnBefore_ = guidedBefore_ = 0;
    for (const GuidedDepth& d : report().depths) {
        drawnBefore_ += d.drawn;
        guidedBefore_ += d.guided;
    }
}

double LiveWork::expose(std::uint32_t spp, v1::Film& film, bool forward, std::uint32_t frame) {
    v1::PassReport done;
    if (forward) {
        renderer_->forward(film, directions_, pass(spp, frame), &done);
    } else if (optimizing()) {
        ensureRecovery();
        recovery_->image(film, settings_.view, spp, &done);
    } else {
        renderer_->render(film, pass(spp), &done);
    }
    return done.seconds;
}

bool LiveWork::previewed(Refined& r, bool forward) {
    const int divisor = r.previewDivisor();
    if (r.film.samples() > 0 || divisor == 1 || optimizing())
        return false;
    previewing_ = true;
    const Seen s = seen();
    v1::Film film(std::max(1, s.width / divisor), std::max(1, s.height / divisor));
    expose(1, film, forward);
    previewing_ = false;
    state_.preview = true;
    auto image = std::make_shared<const Image>(film.image());
    show(forward ? LivePicture::Gradient : LivePicture::Image, std::move(image));
    hooks_.publish();
    hooks_.afterPreview(); // the view may have changed again, which was no reason to end it
    return true;
}

void LiveWork::refine(Refined& r, bool forward) {
    previewed(r, forward);
    std::uint32_t spp = r.nextSamples(settings_.sppLimit);
    const bool beside = !forward && state_.imageCarried;
    if (beside && r.film.samples() == 0)
        spp = std::max(1u, spp / 2); // leaves some to compare with
    const double seconds = expose(spp, r.film, forward);
    r.pathsPerSecond = double(spp) * double(r.film.pixels()) / std::max(1e-6, seconds);
    state_.samplesPerSecond = r.pathsPerSecond;
    state_.preview = false;
    if (!forward)
        showLayers(r.film);
    // After a step there are pictures already of less noise, of the same or almost the same parameters.
    std::uint32_t& shown = forward ? state_.gradientSamples : state_.imageSamples;
    if (beside ? outdoesCarried(r.film) : r.film.samples() >= shown) {
        shown = r.film.samples();
        if (forward) {
            state_.gradientFading = false;
            show(LivePicture::Gradient, std::make_shared<const Image>(r.film.image()));
        } else {
            state_.imageCarried = false;
            showImage(r.film.image());
        }
    }
    updateGuideFigures();
}

void LiveWork::train() {
    v1::PassOptions learning = pass(settings_.spp);
    const Seen s = seen();
    learning.width = s.width;
    learning.height = s.height;
    learning.train = 1;
    learning.trainSpp = settings_.spp;
    if (settings_.mode == LiveMode::Gradient && !settings_.parameters.empty())
        renderer_->train(directions_, learning);
    else
        renderer_->train(learning);
    --training_;
    restartFilms();
    updateGuideFigures();
}

LivePick LiveWork::pick(int x, int y) const {
    LivePick pick;
    pick.x = x;
    pick.y = y;
    pick.settings = settings_;
    pick.guidePasses = state_.guidePasses;
    const Seen s = seen();
    pick.width = s.width;
    pick.height = s.height;
    const std::optional<v1::SurfacePoint> hit = scene_.scene.pick(s.camera, s.width, s.height, float(x) + 0.5f, float(y) + 0.5f);
    if (!hit)
        return pick;
    pick.hit = true;
    pick.position = {hit->position[0], hit->position[1], hit->position[2]};
    pick.normal = {hit->normal[0], hit->normal[1], hit->normal[2]};
    pick.material = hit->material;
    if (renderer_)
        pick.guide = renderer_->guideAt(hit->position, settings_.mode == LiveMode::Render ? v1::PassKind::Render : v1::PassKind::Backward);
    if (!pick.guide)
        return pick;
    constexpr int kMapEdge = 128;
    const auto map = [&](const std::array<double, 3>& weights) { return std::make_shared<const Image>(pick.guide->density(weights, kMapEdge)); };
    pick.maps = {map({1, 0, 0}), map({0, 1, 0}), map({0, 0, 1}), map(pick.guide->weights)};
    return pick;
}

void LiveWork::show(LivePicture picture, std::shared_ptr<const Image> image) {
    state_.pictures[std::size_t(picture)] = std::move(image);
    if (picture == LivePicture::Image && !state_.picture(picture)) {
        state_.imageSamples = 0;
        state_.imageCarried = false;
    }
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

void LiveWork::showLayers(const v1::Film& film) {
    if (!film.hasLayers())
        return;
    Layers layers = film.layers();
    std::optional<Image> cells = renderer_->guideCells(layers.depth, pass(0));
    show(LivePicture::Cells, cells ? std::make_shared<const Image>(std::move(*cells)) : nullptr);
    show(LivePicture::Normal, std::make_shared<const Image>(std::move(layers.normal)));
    show(LivePicture::Depth, std::make_shared<const Image>(std::move(layers.depth)));
    show(LivePicture::Albedo, std::make_shared<const Image>(std::move(layers.albedo)));
    show(LivePicture::Guided, std::make_shared<const Image>(std::move(layers.guided)));
}

void LiveWork::showParameter() {
    if (settings_.parameters.empty())
        return show(LivePicture::Parameter, nullptr);
    const v1::ParameterInfo& p = scene_.parameter(settings_.parameters.front());
    show(LivePicture::Parameter, std::make_shared<const Image>(parameterImage(p, scene_.scene.values(p.name))));
}

void LiveWork::updateGuideFigures() {
    const v1::PassReport now = report();
    state_.guideLearned = now.guideUpdates > 0;
    state_.guideCells = now.guideCells;
    state_.guidePasses = now.guideUpdates;
    state_.sampling = now.sampling;
    state_.roulette = now.roulette;
    std::uint64_t drawn = 0, guided = 0;
    for (const GuidedDepth& depth : now.depths) {
        drawn += depth.drawn;
        guided += depth.guided;
    }
    state_.guidedShare = drawn > drawnBefore_ ? double(guided - guidedBefore_) / double(drawn - drawnBefore_) : 0;
}

} // namespace cmpg

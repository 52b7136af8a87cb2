// The thread of a session: takes requests, does one piece of work, publishes, and so on.
#include "live/live_worker.h"

#include "live/save_picture.h"
#include "session/explain.h"
#include "session/output.h"

#include <new>

namespace cmpg {
namespace {

// Defaults such as samples per step are those of `optimize`; nothing of the options is written or printed.
Options forWindow(Options options) {
    options.command = Command::Optimize;
    return options;
}

LiveMode modeOf(Command command) {
    return command == Command::Optimize ? LiveMode::Optimize : command == Command::Gradient ? LiveMode::Gradient : LiveMode::Render;
}

} // namespace

LiveSettings LiveWorker::settingsAtStart(const Options& given) {
    const Options options = forWindow(given);
    LiveSettings s;
    s.mode = modeOf(given.command);
    s.sampling = options.sampling;
    s.spp = options.effectiveSpp();
    s.sppGradient = options.effectiveSppGradient();
    s.sppLimit = options.spp.value_or(s.sppLimit);
    return s;
}

LiveWorker::LiveWorker(const Options& options, LiveMailbox& mailbox) : options_(forWindow(options)), mailbox_(mailbox) {
    state_.settings = mailbox.wished();
}

void LiveWorker::run() {
    attempt([&] { openDevice(); });
    if (!options_.input.empty())
        attempt([&] { openScene(options_); });
    for (;;) {
        state_.dead = !work_;
        const bool idle = !work_ || stuck_ || !work_->hasWork();
        state_.refining = !idle;
        notice(!work_ ? "drop a scene here: .gltf, .glb or .xml" : stuck_ ? "stopped by an error" : work_->missing(), false);
        auto [requests, wished] = mailbox_.take(idle);
        stuck_ = false;
        if (requests.quit) {
            requests.pick.reset();              // nobody sees the answer
            attempt([&] { answer(requests); }); // files that were asked for are written all the same
            return;
        }
        apply(requests, wished);
        if (!work_ || !work_->hasWork())
            continue;
        stuck_ = !attempt([&] {
            if (!device_) {
                openDevice();
                work_->setDevice(*device_);
            }
            work_->work();
        });
    }
}

template <class F> bool LiveWorker::attempt(F&& f) {
    try {
        f();
        return true;
    } catch (const LiveInterrupted&) {
        work_->recover();
        return true;
    } catch (const Error& error) {
        fail(error);
    } catch (const std::bad_alloc&) {
        fail(Error(ErrorKind::Input, "the host ran out of memory", "the scene or an image is too large for this machine", "use smaller ones"));
    } catch (const std::exception& error) {
        fail(Error(ErrorKind::Numerical, std::string("internal error: ") + error.what(), "this is a mistake in the program", "report it"));
    }
    return false;
}

void LiveWorker::fail(const Error& error) {
    state_.error = {state_.error.number + 1, error.what(), error.cause, remedyOf(error), false};
    if (work_)
        work_->recover();
    if (error.kind == ErrorKind::Device) { // it may be lost, or filled by what did not fit
        if (work_)
            work_->leaveDevice();
        device_.reset();
    }
    publish();
}

void LiveWorker::settle() {
    if (!state_.error.saving)
        state_.error = {state_.error.number, {}, {}, {}, false};
}

void LiveWorker::openDevice() {
    notice("opening the device", true);
    device_.emplace(options_.device);
    state_.device = device_->info().name;
}

void LiveWorker::openScene(const Options& options) {
    notice("loading the scene", true);
    const std::uint32_t number = (state_.scene ? state_.scene->number : 0) + 1;
    auto scene = std::make_unique<LoadedScene>(options, number);
    const LiveSettings initial = scene->initialSettings(options);
    if (!device_) // after what may fail: the scene before has left this device, and knows no other
        openDevice();
    work_.reset();
    scene_ = std::move(scene);
    options_ = options;
    LiveState fresh;
    fresh.version = state_.version;
    fresh.scene = scene_->info;
    fresh.device = state_.device;
    fresh.error = state_.error;
    fresh.message = state_.message;
    state_ = std::move(fresh);
    settle();
    LiveWork::Hooks hooks;
    hooks.betweenSubmissions = [this] { betweenSubmissions(); };
    hooks.afterPreview = [this] { look(); };
    hooks.busyWith = [this](const char* what) { notice(what, *what != 0); };
    hooks.publish = [this] { publish(); };
    work_ = std::make_unique<LiveWork>(options_, *device_, *scene_, state_, std::move(hooks));
    const LiveSettings settings = mailbox_.inspect([&](LiveRequests&, LiveSettings& wished) {
        wished.scene = initial.scene;
        wished.camera = initial.camera;
        wished.width = initial.width;
        wished.height = initial.height;
        wished.parameters = initial.parameters;
        wished.view = 0;
        return wished;
    });
    work_->setSettings(settings);
    attempt([&] { // a scene without its targets is still a scene
        scene_->openTargets(options_);
        work_->targetsChanged();
    });
    publish();
}

void LiveWorker::apply(LiveRequests& r, const LiveSettings& wished) {
    if (r.scene) {
        Options other = options_;
        other.input = r.scene->string();
        other.camera.clear();
        other.param.clear();
        other.texture.clear();
        other.set.clear();
        other.target.clear();
        if (r.target)
            other.target = {*r.target};
        other.mask.clear();
        other.define.clear();
        other.width.reset();
        other.height.reset();
        answer(r);
        attempt([&] { openScene(other); });
        return; // wishes for the old scene are void; those for the new one follow
    }
    if (!work_) {
        answer(r);
        if (r.target)
            attempt([&] { throw Error(ErrorKind::Usage, "there is no scene that " + *r.target + " could be a target of", "", "open the scene first, or both together"); });
        return;
    }
    attempt([&] {
        if (r.target)
            scene_->openTarget(options_, *r.target, wished.camera.name);
        else if (r.imageAsTarget)
            useAsTarget(*r.imageAsTarget);
        if (r.target || r.imageAsTarget) {
            work_->targetsChanged();
            settle();
        }
    });
    if (wished.scene == work_->settings().scene)
        work_->setSettings(work_->sanitised(wished));
    answer(r);
    if (r.reset || r.fill)
        attempt([&] { work_->reset(r.fill); });
    work_->addTraining(r.train);
    work_->addSteps(r.steps);
}

void LiveWorker::useAsTarget(const LiveState& shown) {
    const auto& image = shown.picture(LivePicture::Image);
    if (!image || shown.preview || shown.settings.scene != work_->settings().scene)
        throw Error(ErrorKind::Usage, "there is no image yet to make a target of", "the view has just changed", "wait for the image");
    const bool ofTarget = LiveWork::optimizes(shown.settings, shown.views) && shown.settings.view < scene_->views();
    const v1::CameraInfo seenBy = ofTarget ? *scene_->targets[shown.settings.view].from : shown.settings.camera;
    scene_->setTarget(seenBy, *image);
}

void LiveWorker::betweenSubmissions() {
    if (mailbox_.unseen())
        look();
}

void LiveWorker::look() {
    LiveRequests quick;
    const bool outdated = mailbox_.inspect([&](LiveRequests& r, const LiveSettings& wished) {
        quick.pick = std::exchange(r.pick, {});
        quick.saves = std::exchange(r.saves, {});
        quick.sceneFolder = std::exchange(r.sceneFolder, {});
        return r.restart() || (wished.scene == work_->settings().scene && work_->outdates(work_->sanitised(wished)));
    });
    answer(quick);
    if (outdated)
        throw LiveInterrupted{};
}

void LiveWorker::answer(const LiveRequests& quick) {
    const auto failing = [&](auto&& f) { // without touching the pass under way
        try {
            f();
        } catch (const Error& error) {
            state_.error = {state_.error.number + 1, error.what(), error.cause, remedyOf(error), true};
        }
    };
    for (const LiveSave& save : quick.saves)
        failing([&] {
            makeFolder(folderOf(save.file)); // that of -o need not be there yet
            save.write();
            tell("saved " + save.file.string());
        });
    if (quick.sceneFolder && scene_)
        failing([&] {
            makeFolder(*quick.sceneFolder);
            requireWritableFolder(*quick.sceneFolder);
            tell("saved " + scene_->scene.exportTo(*quick.sceneFolder, scene_->changed()).string());
        });
    if (quick.pick && work_) {
        const auto [x, y] = *quick.pick;
        LivePick pick = work_->pick(x, y);
        pick.number = (state_.pick ? state_.pick->number : 0) + 1;
        state_.pick = std::make_shared<const LivePick>(std::move(pick));
    }
    if (quick.pick || quick.sceneFolder || !quick.saves.empty())
        publish();
}

void LiveWorker::tell(const std::string& message) { state_.message = {state_.message.number + 1, message}; }

void LiveWorker::notice(const std::string& text, bool busy) {
    state_.notice = text;
    state_.busy = busy;
    publish();
}

void LiveWorker::publish() {
    ++state_.version;
    mailbox_.publish(state_);
}

} // namespace cmpg

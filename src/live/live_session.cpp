// The front of a session: wishes go into the mailbox, states come out of it.
#include "live/live_session.h"

#include "live/live_mailbox.h"
#include "live/live_worker.h"
#include "live/save_picture.h"

#include <thread>

namespace cmpg {

struct LiveSession::Impl {
    LiveMailbox mailbox;
    std::thread worker;

    Impl(const Options& options, std::function<void()> notify) : mailbox(std::move(notify)) {
        mailbox.ask([&](LiveRequests&, LiveSettings& wished) { wished = LiveWorker::settingsAtStart(options); });
        worker = std::thread([this, options] { LiveWorker(options, mailbox).run(); });
    }
    ~Impl() {
        mailbox.ask([](LiveRequests& r, LiveSettings&) { r.quit = true; });
        worker.join();
    }
};

const char* livePictureName(LivePicture picture) {
    static constexpr const char* kNames[kLivePictures] = {"image", "target", "difference", "gradient", "parameter", "parameter gradient",
                                                          "normal", "depth", "albedo", "guided", "cells"};
    return kNames[std::size_t(picture)];
}

const v1::ParameterInfo* shownParameter(const LiveState& state) {
    if (!state.scene || state.settings.parameters.empty() || state.settings.parameters.front() >= state.scene->parameters.size())
        return nullptr;
    return &state.scene->parameters[state.settings.parameters.front()];
}

LiveColors colorsOf(const LiveState& state, LivePicture picture) {
    switch (picture) {
    case LivePicture::Difference:
    case LivePicture::Gradient:
    case LivePicture::ParameterGradient: return LiveColors::Signed;
    case LivePicture::Depth:
    case LivePicture::Guided: return LiveColors::Heat;
    case LivePicture::Normal: return LiveColors::Directions;
    case LivePicture::Cells: return LiveColors::Labels;
    case LivePicture::Albedo: return LiveColors::Plain;
    case LivePicture::Parameter: {
        const v1::ParameterInfo* const parameter = shownParameter(state);
        if (const auto& image = state.picture(picture); image && image->channels == 1)
            return LiveColors::Heat;
        if (parameter && parameter->slot == "normal")
            return LiveColors::Directions;
        return parameter && (parameter->slot == "emission" || parameter->slot == "radiance") ? LiveColors::Radiance : LiveColors::Plain;
    }
    default: return LiveColors::Radiance;
    }
}

LiveSession::LiveSession(const Options& options, std::function<void()> notify) : impl_(std::make_unique<Impl>(options, std::move(notify))) {}

LiveSession::~LiveSession() = default;

std::shared_ptr<const LiveState> LiveSession::state() const { return impl_->mailbox.state(); }

LiveSettings LiveSession::settings() const { return impl_->mailbox.wished(); }

void LiveSession::set(const LiveSettings& settings) {
    impl_->mailbox.ask([&](LiveRequests&, LiveSettings& wished) {
        const LiveSettings before = std::exchange(wished, settings);
        if (settings.scene == before.scene)
            return;
        wished.scene = before.scene;
        wished.camera = before.camera;
        wished.parameters = before.parameters;
        wished.view = before.view;
    });
}

void LiveSession::change(const std::function<void(LiveSettings&)>& edit) {
    impl_->mailbox.ask([&](LiveRequests&, LiveSettings& wished) {
        const std::uint32_t scene = wished.scene;
        edit(wished);
        wished.scene = scene;
    });
}

void LiveSession::stepOnce(std::uint32_t steps) {
    impl_->mailbox.ask([&](LiveRequests& r, LiveSettings&) { r.steps += steps; });
}

void LiveSession::reset() {
    impl_->mailbox.ask([](LiveRequests& r, LiveSettings&) {
        r.reset = true;
        r.fill.reset();
        r.steps = 0;
    });
}

void LiveSession::fill(float value) {
    impl_->mailbox.ask([&](LiveRequests& r, LiveSettings&) {
        r.fill = value;
        r.steps = 0;
    });
}

void LiveSession::train(std::uint32_t passes) {
    impl_->mailbox.ask([&](LiveRequests& r, LiveSettings&) { r.train += passes; });
}

void LiveSession::openScene(const std::filesystem::path& file, const std::optional<std::string>& target) {
    impl_->mailbox.ask([&](LiveRequests& r, LiveSettings&) {
        LiveRequests next;
        next.saves = std::move(r.saves); // of what was seen before
        next.sceneFolder = std::move(r.sceneFolder);
        next.scene = file;
        next.target = target;
        r = std::move(next);
    });
}

void LiveSession::openTarget(const std::string& target) {
    impl_->mailbox.ask([&](LiveRequests& r, LiveSettings&) {
        r.target = target;
        r.imageAsTarget = nullptr;
    });
}

void LiveSession::useImageAsTarget() {
    impl_->mailbox.ask([shown = state()](LiveRequests& r, LiveSettings&) {
        if (r.scene) // the image is of the one before
            return;
        r.imageAsTarget = shown;
        r.target.reset();
    });
}

void LiveSession::pick(int x, int y) {
    impl_->mailbox.ask([&](LiveRequests& r, LiveSettings&) { r.pick = {x, y}; });
}

void LiveSession::save(LivePicture picture, const std::filesystem::path& file, const LiveLook& look) {
    const auto shown = state();
    const auto write = [image = shown->picture(picture), colors = colorsOf(*shown, picture), picture, file, look] {
        if (!image)
            throw Error(ErrorKind::Output, std::string("there is no ") + livePictureName(picture) + " to save yet");
        savePicture(colors, *image, file, look);
    };
    impl_->mailbox.ask([&](LiveRequests& r, LiveSettings&) { r.saves.push_back({file, write}); });
}

void LiveSession::saveLoss(const std::filesystem::path& file) {
    const auto write = [loss = state()->loss, file] {
        if (!loss || loss->empty())
            throw Error(ErrorKind::Output, "there is no loss to save yet");
        cmpg::saveLoss(*loss, file);
    };
    impl_->mailbox.ask([&](LiveRequests& r, LiveSettings&) { r.saves.push_back({file, write}); });
}

void LiveSession::saveScene(const std::filesystem::path& folder) {
    impl_->mailbox.ask([&](LiveRequests& r, LiveSettings&) { r.sceneFolder = folder; });
}

} // namespace cmpg

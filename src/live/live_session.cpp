// The front of a live session: wishes and snapshots.
#include "live/live_session.h"

#include <mutex>

namespace cmpg {

struct LiveSession::Impl {
    mutable std::mutex mutex;
    std::shared_ptr<const LiveState> state = std::make_shared<LiveState>();
    LiveSettings wished;
    std::function<void()> notify;
};

const char* livePictureName(LivePicture picture) {
    static constexpr const char* kNames[kLivePictures] = {"image", "target", "difference", "gradient", "parameter", "parameter gradient",
                                                          "normal", "depth", "albedo", "guided", "cells"};
    return kNames[std::size_t(picture)];
}

bool isSigned(LivePicture p) { return p == LivePicture::Difference || p == LivePicture::Gradient || p == LivePicture::ParameterGradient; }

LiveSession::LiveSession(const Options&, std::function<void()> notify) : impl_(std::make_unique<Impl>()) { impl_->notify = std::move(notify); }
LiveSession::~LiveSession() = default;
std::shared_ptr<const LiveState> LiveSession::state() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->state;
}
void LiveSession::set(const LiveSettings& settings) {
    change([&](LiveSettings& s) { s = settings; });
}
LiveSettings LiveSession::settings() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->wished;
}
void LiveSession::change(const std::function<void(LiveSettings&)>& edit) {
    const std::lock_guard lock(impl_->mutex);
    edit(impl_->wished);
}
void LiveSession::stepOnce(std::uint32_t) {}
void LiveSession::reset() {}
void LiveSession::fill(float) {}
void LiveSession::train(std::uint32_t) {}
void LiveSession::openScene(const std::filesystem::path&) {}
void LiveSession::openTarget(const std::string&) {}
void LiveSession::useImageAsTarget() {}
void LiveSession::pick(int, int) {}
void LiveSession::save(LivePicture, const std::filesystem::path&, const LiveLook&) {}
void LiveSession::saveScene(const std::filesystem::path&) {}

} // namespace cmpg

// How values become colours, and which value gets the deepest.
#include "viewer/picture_look.h"

#include "imaging/signed_colors.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {

double largest(const Image& image) {
    float most = 0;
    for (const float v : image.values)
        if (std::isfinite(v))
            most = std::max(most, v);
    return most > 0 ? double(most) : 1;
}

bool isMeasured(const LiveState& state, LivePicture picture) {
    return isSigned(picture) || picture == LivePicture::Depth || (picture == LivePicture::Parameter && state.picture(picture)->channels == 1);
}

const v1::ParameterInfo* shownParameter(const LiveState& state) {
    if (!state.scene || state.settings.parameters.empty() || state.settings.parameters.front() >= state.scene->parameters.size())
        return nullptr;
    return &state.scene->parameters[state.settings.parameters.front()];
}

} // namespace

void Looks::update(const LiveState& state, std::span<const LivePicture> pictures) {
    shared_ = 0;
    for (const LivePicture picture : pictures) {
        const auto& image = state.picture(picture);
        if (!image || !isMeasured(state, picture))
            continue;
        Measured& measured = measured_[picture];
        if (measured.image != image)
            measured = {image, isSigned(picture) ? signedScale(channelMean(*image)) : largest(*image)};
        if (isSigned(picture))
            shared_ = std::max(shared_, measured.scale);
    }
}

PictureLook Looks::of(const LiveState& state, LivePicture picture) const {
    PictureLook look;
    const auto found = measured_.find(picture);
    const double measured = found == measured_.end() ? 1 : found->second.scale;
    const float exposure = std::exp2(settings.exposure);
    if (isSigned(picture)) {
        look.kind = gpu::kPanelSigned;
        look.isSigned = true;
        look.scale = settings.rule == ScaleRule::Fixed ? double(settings.fixedScale) : settings.rule == ScaleRule::Shared ? shared_ : measured;
        look.factor = float(1 / look.scale);
        return look;
    }
    const v1::ParameterInfo* const parameter = shownParameter(state);
    switch (picture) {
    case LivePicture::Parameter:
        if (state.picture(picture) && state.picture(picture)->channels == 1) {
            look.kind = gpu::kPanelScalar;
            look.scale = parameter && std::isfinite(parameter->highest) ? double(parameter->highest) : measured;
            look.factor = float(1 / look.scale);
        } else if (parameter && parameter->slot == "normal") {
            look.kind = gpu::kPanelDirection;
        } else if (parameter && (parameter->slot == "emission" || parameter->slot == "radiance")) {
            look.factor = exposure;
        }
        break;
    case LivePicture::Normal:
        look.kind = gpu::kPanelDirection;
        break;
    case LivePicture::Depth:
    case LivePicture::Guided:
        look.kind = gpu::kPanelScalar;
        look.scale = picture == LivePicture::Depth ? measured : 1;
        look.factor = float(1 / look.scale);
        break;
    case LivePicture::Cells:
        look.kind = gpu::kPanelCells;
        break;
    case LivePicture::Albedo:
        break;
    default:
        look.factor = exposure;
    }
    return look;
}

LiveLook Looks::forFile(const LiveState& state, LivePicture picture) const {
    LiveLook look;
    look.exposure = settings.exposure;
    if (isSigned(picture))
        look.scale = of(state, picture).scale;
    return look;
}

} // namespace cmpg::viewer

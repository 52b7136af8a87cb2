// How values become colours, and which value gets the deepest.
#include "viewer/picture_look.h"

#include "imaging/display_image.h"
#include "imaging/signed_colors.h"

#include <algorithm>
#include <cmath>

namespace cmpg::viewer {
namespace {

gpu::uint kindOf(LiveColors colors) {
    switch (colors) {
    case LiveColors::Signed: return gpu::kPanelSigned;
    case LiveColors::Heat: return gpu::kPanelScalar;
    case LiveColors::Directions: return gpu::kPanelDirection;
    case LiveColors::Labels: return gpu::kPanelCells;
    default: return gpu::kPanelColor;
    }
}

// The end of the colours where it is not measured: that of the range of what they show. 0: there is none.
double highestOf(const LiveState& state, LivePicture picture) {
    if (picture == LivePicture::Guided)
        return 1;
    const v1::ParameterInfo* const parameter = picture == LivePicture::Parameter ? shownParameter(state) : nullptr;
    return parameter && std::isfinite(parameter->highest) ? double(parameter->highest) : 0;
}

} // namespace

void Looks::update(const LiveState& state, std::span<const LivePicture> pictures) {
    shared_ = 0;
    for (const LivePicture picture : pictures) {
        const auto& image = state.picture(picture);
        const LiveColors colors = colorsOf(state, picture);
        if (!image || (colors != LiveColors::Signed && colors != LiveColors::Heat))
            continue;
        Measured& measured = measured_[picture];
        if (measured.image != image)
            measured = {image, colors == LiveColors::Signed ? signedScale(channelMean(*image)) : heatScale(*image)};
        if (colors == LiveColors::Signed)
            shared_ = std::max(shared_, measured.scale);
    }
}

PictureLook Looks::of(const LiveState& state, LivePicture picture) const {
    PictureLook look;
    const auto found = measured_.find(picture);
    const double measured = found == measured_.end() ? 1 : found->second.scale;
    const LiveColors colors = colorsOf(state, picture);
    look.kind = kindOf(colors);
    look.isSigned = colors == LiveColors::Signed;
    if (colors == LiveColors::Signed) {
        look.scale = settings.rule == ScaleRule::Fixed ? double(settings.fixedScale) : settings.rule == ScaleRule::Shared ? shared_ : measured;
    } else if (colors == LiveColors::Heat) {
        const double highest = highestOf(state, picture);
        look.scale = highest > 0 ? highest : measured;
    } else if (colors == LiveColors::Radiance) {
        look.factor = std::exp2(settings.exposure);
    }
    if (look.scale > 0)
        look.factor = float(1 / look.scale);
    return look;
}

LiveLook Looks::forFile(const LiveState& state, LivePicture picture) const {
    LiveLook look;
    look.exposure = settings.exposure;
    look.scale = of(state, picture).scale;
    return look;
}

} // namespace cmpg::viewer

// What a session shows as files: pictures, the loss.
#pragma once

#include "live/live_session.h"

#include <span>

namespace cmpg {

// .exr: the values as they are; .png: in these colours, as `look` says. Error(Output) on other endings and where nothing can be written.
void savePicture(LiveColors colors, const Image& image, const std::filesystem::path& file, const LiveLook& look);

// The loss before every step. .csv: the values; .png: their curve. Error(Output) on other endings and where nothing can be written.
void saveLoss(std::span<const double> loss, const std::filesystem::path& file);

} // namespace cmpg

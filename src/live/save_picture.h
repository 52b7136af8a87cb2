// A picture of a session as a file.
#pragma once

#include "live/live_session.h"

namespace cmpg {

// .exr: the values as they are; .png: as `look` says. Error(Output) on other endings and where nothing can be written.
void savePicture(LivePicture picture, const Image& image, const std::filesystem::path& file, const LiveLook& look);

} // namespace cmpg

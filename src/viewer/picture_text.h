// What is written beside a picture.
#pragma once

#include "live/live_session.h"

namespace cmpg::viewer {

std::string titleOf(const LiveState& state, LivePicture picture);
std::string detailOf(const LiveState& state, LivePicture picture); // how many samples, whose parameter, which file
std::string emptyText(const LiveState& state, LivePicture picture); // why there is nothing to see
std::string valueText(const Image& image, glm::ivec2 pixel, LivePicture picture);
// Of a point in the coordinates of `scene`: in those of its file, with as many decimals as tell a thousandth of the scene.
std::string pointText(const LiveScene& scene, glm::vec3 position);
// Of the window: what is shown of which scene, and how far it is.
std::string windowTitle(const LiveState& state, const std::string& scene);
// Names of the selected parameters; the first and the number of the others where they are many.
std::string parametersText(const LiveState& state);

} // namespace cmpg::viewer

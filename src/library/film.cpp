// Films of the library's surface.
#include "library/film_state.h"

#include "base/error.h"
#include "library/states.h"

namespace cmpg::v1 {
namespace {

const cmpg::Film& filled(const Film::State& state) {
    if (state.film.samples == 0)
        throw Error(ErrorKind::Usage, "the film has no samples yet", {}, "have a pass add some");
    return state.film;
}

} // namespace

Film::Film() : state_(std::make_shared<State>()) {}

Film::Film(int width, int height, bool layers) : Film() {
    require(width >= 1 && width <= kMostEdge, "width", "from 1 to 32768");
    require(height >= 1 && height <= kMostEdge, "height", "from 1 to 32768");
    state_->film = cmpg::Film(width, height, layers);
}

int Film::width() const { return state_->film.width; }
int Film::height() const { return state_->film.height; }
bool Film::hasLayers() const { return state_->film.hasLayers(); }

std::uint32_t Film::samples() const {
    const std::lock_guard lock(state_->mutex);
    return state_->film.samples;
}

Image Film::image() const {
    const std::lock_guard lock(state_->mutex);
    return filled(*state_).image();
}

Layers Film::layers() const {
    const std::lock_guard lock(state_->mutex);
    if (!hasLayers())
        throw Error(ErrorKind::Usage, "the film has no layers", {}, "make one with layers", {"layers"});
    return filled(*state_).layers();
}

} // namespace cmpg::v1

// What stands behind a film of the library's surface.
#pragma once

#include "render/film.h"

#include <cmpg/film.h>

#include <mutex>

namespace cmpg::v1 {

struct Film::State {
    // Of a pass that adds samples, and of whoever reads them. Locked after that of the device; a pass may be looked at from within.
    std::recursive_mutex mutex;
    cmpg::Film film; // whose size stays
};

} // namespace cmpg::v1

// What stands behind a film of the library's surface.
#pragma once

#include "render/film.h"

#include <cmpg/film.h>

namespace cmpg::v1 {

struct Film::State {
    cmpg::Film film;
};

} // namespace cmpg::v1

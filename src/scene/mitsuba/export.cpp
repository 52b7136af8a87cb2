// Writes a Mitsuba scene back with changed parameters.
#include "base/error.h"
#include "scene/mitsuba/mitsuba.h"

namespace cmpg {

void writeMitsuba(const Scene& scene, const std::vector<std::uint32_t>&, const std::filesystem::path&) {
    throw Error(ErrorKind::Output, "cannot export " + scene.source + " as Mitsuba XML");
}

} // namespace cmpg

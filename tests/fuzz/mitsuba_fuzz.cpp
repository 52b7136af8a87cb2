// Scenes in Mitsuba's XML format, with what the renderer makes of them on the host.
#include "scene_folder.h"

using namespace cmpg;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::SceneFolder folder("scene.xml");
    const auto file = folder.holding({data, size});
    fuzz::accepts({ErrorKind::Input}, [&] { fuzz::useScene(file); });
    return 0;
}

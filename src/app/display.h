// --display-server in commands: what they show.
#pragma once

#include "imaging/display_stream.h"
#include "session/options.h"

#include <filesystem>
#include <functional>

namespace cmpg {

// Images are called after the output: "run/gradient.painting.baseColor" for -o run, "a/image" for -o a.exr.
inline std::string displayTitle(const Options& options) {
    std::filesystem::path output = options.output;
    if (output.filename().empty())
        output = output.parent_path();
    return (output.extension() == ".exr" ? output.stem() : output.filename()).string(); // folders have no ending, only names with dots
}

// What shows an image as it grows; empty without a display.
inline std::function<void(const Image&)> shownIn(DisplayStream& display, const std::string& name) {
    if (!display.active())
        return {};
    return [&display, name](const Image& image) { display.show(name, image); };
}

} // namespace cmpg

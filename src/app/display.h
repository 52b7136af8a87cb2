// --display-server in commands: what they show, and passes in parts so that there is something to show early.
#pragma once

#include "imaging/display_stream.h"
#include "render/film.h"
#include "session/options.h"

#include <chrono>

namespace cmpg {

// Images are called after the output: "run/gradient.painting.baseColor" for -o run.
inline std::string displayTitle(const Options& options) {
    std::filesystem::path output = options.output;
    if (output.filename().empty())
        output = output.parent_path();
    return output.stem().string();
}

// Adds `spp` samples to a film by pass(samples), in growing parts of at most about half a second, and shows it after each. The film is what
// one pass would have made.
template <class Pass> void showGrowing(DisplayStream& display, const std::string& name, Film& film, std::uint32_t spp, Pass&& pass) {
    constexpr std::chrono::duration<double> kLong(0.5);
    std::uint32_t part = 1;
    while (film.samples < spp) {
        const auto start = std::chrono::steady_clock::now();
        part = std::min(part, spp - film.samples);
        pass(part);
        display.show(name, film.image());
        if (std::chrono::steady_clock::now() - start < kLong / 2)
            part *= 2;
    }
}

} // namespace cmpg

// What the module of the window exports.
#pragma once

namespace cmpg {

struct Options;

// `extern "C"`. Shows the window until it is closed, explains its errors itself, and returns the exit code.
using ViewerMain = int (*)(const Options& options);
constexpr const char* kViewerMain = "cmpgViewerMain";

} // namespace cmpg

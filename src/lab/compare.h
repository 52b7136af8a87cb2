// compare and tradeoff from their options to their files.
#pragma once

#include "session/report.h"

#include <functional>
#include <string>

namespace cmpg {

// Called now and then with what is being done. What it throws ends the measurement.
using ProgressText = std::function<void(const std::string&)>;

// Sampling methods side by side, for derivative images, gradients and whole optimisations. Writes tables, images and a page to the folder of the
// options; the table is also report.extra["table"], a row per method.
void compare(const Options& options, Report& report, const ProgressText& progress);

// Which options trade speed for accuracy on a scene, which of them are on the frontier, and what each costs when left out. Files and table likewise, a
// row per setting. Returns the tables as text.
std::string tradeoff(const Options& options, Report& report, const ProgressText& progress);

} // namespace cmpg

// What the program tells on stderr besides its results.
#pragma once

#include <string_view>

namespace cmpg {

void setQuiet(bool quiet);               // silences logInfo()
void logInfo(std::string_view message);  // progress and findings
void logWarn(std::string_view message);  // shown even when quiet

} // namespace cmpg

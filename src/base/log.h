// What the program tells on stderr besides its results.
#pragma once

#include <functional>
#include <string_view>

namespace cmpg {

enum class LogLevel { Info, Warning, Error };

// `event`: a short name for what happened, for those who search a log.
void logWarn(std::string_view message, std::string_view event = "warning");

// Also hears of everything, from any thread, one at a time: who keeps the log of a run. Empty: nobody.
void setLogListener(std::function<void(LogLevel level, std::string_view event, std::string_view message)> listener);

} // namespace cmpg

// One line per message, written at once so that threads do not mix theirs.
#include "base/log.h"

#include <atomic>
#include <cstdio>
#include <mutex>
#include <string>

namespace cmpg {

namespace {
std::atomic<bool> quietMode = false;
std::mutex listenerMutex;
std::function<void(LogLevel, std::string_view, std::string_view)> listener;

void print(std::string_view prefix, std::string_view message) {
    std::string line;
    line.append(prefix).append(message).push_back('\n');
    std::fwrite(line.data(), 1, line.size(), stderr);
}

void tell(LogLevel level, std::string_view event, std::string_view message) {
    const std::lock_guard lock(listenerMutex);
    if (listener)
        listener(level, event, message);
}
} // namespace

void setQuiet(bool quiet) { quietMode = quiet; }

void logInfo(std::string_view message) {
    if (!quietMode)
        print("", message);
    tell(LogLevel::Info, "info", message);
}

void logWarn(std::string_view message, std::string_view event) {
    print("warning: ", message);
    tell(LogLevel::Warning, event, message);
}

void setLogListener(std::function<void(LogLevel, std::string_view, std::string_view)> newListener) {
    const std::lock_guard lock(listenerMutex);
    listener = std::move(newListener);
}

} // namespace cmpg

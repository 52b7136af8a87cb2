// One line per message, written at once so that threads do not mix theirs.
#include "base/log.h"

#include <cstdio>
#include <mutex>
#include <string>

namespace cmpg {

namespace {
std::mutex listenerMutex;
std::function<void(LogLevel, std::string_view, std::string_view)> listener;
} // namespace

void logWarn(std::string_view message, std::string_view event) {
    std::string line("warning: ");
    line.append(message).push_back('\n');
    std::fwrite(line.data(), 1, line.size(), stderr);
    const std::lock_guard lock(listenerMutex);
    if (listener)
        listener(LogLevel::Warning, event, message);
}

void setLogListener(std::function<void(LogLevel, std::string_view, std::string_view)> newListener) {
    const std::lock_guard lock(listenerMutex);
    listener = std::move(newListener);
}

} // namespace cmpg

// One line per message, written at once so that threads do not mix theirs.
#include "base/log.h"

#include <atomic>
#include <cstdio>
#include <string>

namespace cmpg {

namespace {
std::atomic<bool> quietMode = false;

void print(std::string_view prefix, std::string_view message) {
    std::string line;
    line.append(prefix).append(message).push_back('\n');
    std::fwrite(line.data(), 1, line.size(), stderr);
}
} // namespace

void setQuiet(bool quiet) { quietMode = quiet; }

void logInfo(std::string_view message) {
    if (!quietMode)
        print("", message);
}

void logWarn(std::string_view message) { print("warning: ", message); }

} // namespace cmpg

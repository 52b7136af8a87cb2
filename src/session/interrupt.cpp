// Ctrl-C: end at once, or after the step in flight.
#include "session/interrupt.h"

#include "session/exit_status.h"

#include <csignal>
#include <unistd.h>

namespace cmpg {
namespace {

std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free); // a signal handler may touch nothing else

void exitNow(int) {
    constexpr char kMessage[] = "\ninterrupted\n";
    [[maybe_unused]] const auto written = write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
    _exit(int(ExitStatus::Interrupted));
}

void requestStop(int signal) {
    if (requested.exchange(true))
        exitNow(signal);
}

void handle(void (*handler)(int)) {
    std::signal(SIGINT, handler);
    std::signal(SIGTERM, handler);
}

} // namespace

const std::atomic<bool>& stopOnInterrupt() {
    handle(requestStop);
    return requested;
}

bool stopRequested() { return requested.load(); }

void exitOnInterrupt() {
    handle(exitNow);
}

} // namespace cmpg

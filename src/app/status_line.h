// What a long command is doing: one line on a terminal, overwritten; elsewhere a line every ten seconds.
#pragma once

#include "base/stopwatch.h"
#include "session/options.h"

#include <iostream>
#include <unistd.h>

namespace cmpg {

class StatusLine {
  public:
    explicit StatusLine(const Options& options) : shown_(!options.quiet), terminal_(isatty(STDERR_FILENO) != 0) {}
    ~StatusLine() {
        if (shown_ && terminal_)
            std::cerr << "\r\033[K";
    }
    void operator()(const std::string& text) {
        const double now = watch_.seconds();
        if (!shown_ || now < next_)
            return;
        next_ = now + (terminal_ ? 0.2 : 10);
        if (terminal_)
            std::cerr << "\r\033[K" << text << std::flush;
        else
            std::cerr << text << '\n';
    }

  private:
    bool shown_, terminal_;
    Stopwatch watch_;
    double next_ = 0;
};

} // namespace cmpg

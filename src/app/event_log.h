// The log of a run: one JSON object per line and event, with time, level and step.
#pragma once

#include "base/log.h"

#include <filesystem>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace cmpg {

//   {"time":"2026-03-01T04:05:06.789Z","level":"warning","step":41,"event":"write_failed","text":"...","bytes":512}
// Every warning of the program goes there too. Each line opens and closes the file, so that the log goes on where its folder vanished and
// came back; a line that cannot be written is lost, and no error.
class EventLog {
  public:
    using Numbers = std::vector<std::pair<std::string, double>>;

    explicit EventLog(std::filesystem::path file); // empty: nothing is kept
    ~EventLog();
    EventLog(const EventLog&) = delete;

    void setStep(std::uint32_t step); // of the events to come: how many are done
    void info(const std::string& event, const std::string& text, Numbers numbers = {}); // to the file alone
    void warn(const std::string& event, const std::string& text, Numbers numbers = {}); // on stderr, too

  private:
    void write(LogLevel level, std::string_view event, std::string_view text);

    std::filesystem::path file_;
    std::mutex mutex_; // of the rest
    std::uint32_t step_ = 0;
    Numbers numbers_; // of the event that is being written
};

} // namespace cmpg

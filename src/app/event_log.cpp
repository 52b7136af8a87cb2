// The log of a run.
#include "app/event_log.h"

#include <chrono>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

namespace cmpg {
namespace {

std::string now() {
    const auto time = std::chrono::system_clock::now().time_since_epoch();
    const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
    const std::time_t seconds = std::time_t(milliseconds / 1000);
    std::tm utc{};
    gmtime_r(&seconds, &utc);
    char day[32], text[40];
    std::strftime(day, sizeof day, "%Y-%m-%dT%H:%M:%S", &utc);
    std::snprintf(text, sizeof text, "%s.%03dZ", day, int(milliseconds % 1000));
    return text;
}

const char* nameOf(LogLevel level) {
    constexpr const char* kNames[] = {"info", "warning", "error"};
    return kNames[std::size_t(level)];
}

} // namespace

EventLog::EventLog(std::filesystem::path file) : file_(std::move(file)) {
    setLogListener([this](LogLevel level, std::string_view event, std::string_view text) { write(level, event, text); });
}

EventLog::~EventLog() { setLogListener({}); }

void EventLog::setStep(std::uint32_t step) {
    const std::lock_guard lock(mutex_);
    step_ = step;
}

void EventLog::info(const std::string& event, const std::string& text, Numbers numbers) {
    {
        const std::lock_guard lock(mutex_);
        numbers_ = std::move(numbers);
    }
    write(LogLevel::Info, event, text);
}

void EventLog::warn(const std::string& event, const std::string& text, Numbers numbers) {
    {
        const std::lock_guard lock(mutex_);
        numbers_ = std::move(numbers);
    }
    logWarn(text, event);
}

void EventLog::write(LogLevel level, std::string_view event, std::string_view text) {
    if (file_.empty())
        return;
    const std::lock_guard lock(mutex_);
    nlohmann::ordered_json line;
    line["time"] = now();
    line["level"] = nameOf(level);
    line["step"] = step_;
    line["event"] = event;
    line["text"] = text;
    for (const auto& [name, value] : std::exchange(numbers_, {}))
        line[name] = value;
    std::ofstream(file_, std::ios::app) << line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n" << std::flush;
}

} // namespace cmpg

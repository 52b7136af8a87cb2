// What the program ends with.
#pragma once

#include "base/error.h"

namespace cmpg {

// Documented in docs/usage.md.
enum class ExitStatus : int {
    Done = 0,
    CheckFailed = 1, // a check failed or a target was not reached
    Usage = 2,
    Input = 3,
    Device = 4,
    Numerical = 5,
    Output = 6,
    Interrupted = 130,
};

constexpr ExitStatus exitStatusOf(ErrorKind kind) {
    switch (kind) {
    case ErrorKind::Usage:
        return ExitStatus::Usage;
    case ErrorKind::Input:
        return ExitStatus::Input;
    case ErrorKind::Device:
        return ExitStatus::Device;
    case ErrorKind::Numerical:
        return ExitStatus::Numerical;
    case ErrorKind::Output:
        break;
    }
    return ExitStatus::Output;
}

// An error that is the finding of a check somebody asked for.
class CheckFailed : public Error {
  public:
    explicit CheckFailed(const Error& error) : Error(error) {}
};

} // namespace cmpg

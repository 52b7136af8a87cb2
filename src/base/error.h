// The one exception type: what went wrong, the likely cause, the remedy, and the exit code the program ends with.
#pragma once

#include <stdexcept>
#include <string>

namespace cmpg {

// Exit codes of the program, documented in the README.
enum class ExitCode : int {
    Done = 0,
    CheckFailed = 1, // a check failed or a target was not reached
    Usage = 2,
    Input = 3,  // scene, image or other input file
    Device = 4, // no Vulkan device, or one that lacks a required feature or computes wrong results
    Numerical = 5,
    Output = 6, // a result could not be written
    Interrupted = 130,
};

class Error : public std::runtime_error {
  public:
    // `what`: one sentence naming the file, parameter or device. `cause` and `remedy` may be empty.
    Error(ExitCode exitCode, const std::string& what, std::string likelyCause = {}, std::string howToFix = {})
        : std::runtime_error(what), code(exitCode), cause(std::move(likelyCause)), remedy(std::move(howToFix)) {}

    ExitCode code;
    std::string cause;
    std::string remedy;
};

} // namespace cmpg

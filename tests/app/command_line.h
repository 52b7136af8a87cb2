// Helpers of the command line's tests: parsing, running the program, temporary folders.
#pragma once

#include "base/error.h"
#include "session/options.h"
#include "support/temp_folder.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace cmpg::test {

// Arguments without the program's name.
Options parse(const std::vector<std::string>& arguments);
// Kind of the Error that parsing throws; nothing when it throws none.
std::optional<ErrorKind> parseCode(const std::vector<std::string>& arguments);

struct ProgramResult {
    int code = -1; // exit code; 128 + signal if it was killed
    std::string out, err;
};
ProgramResult runProgram(const std::vector<std::string>& arguments, const std::vector<std::string>& environment = {}); // "NAME=VALUE"

// The program in a process of its own, to be disturbed while it works.
class RunningProgram {
  public:
    // Its output goes to files in `folder`. `prepare` runs in the new process before the program does.
    RunningProgram(const std::vector<std::string>& arguments, const std::string& folder, const std::vector<std::string>& environment = {},
                   const std::function<void()>& prepare = {});
    ~RunningProgram(); // kills it
    RunningProgram(const RunningProgram&) = delete;

    int pid() const { return pid_; }
    bool running();
    void kill(int signal);
    ProgramResult wait(); // for its end

  private:
    int pid_ = -1, status_ = -1;
    std::string folder_;
};

// A folder of its own that goes with the object, and its files as arguments name them.
class TemporaryFolder {
  public:
    std::string operator/(const std::string& name) const { return folder_ / name; }
    std::string path() const { return folder_.path(); }

  private:
    TempFolder folder_;
};

void writeText(const std::string& file, const std::string& text);
std::string readText(const std::string& file);

} // namespace cmpg::test

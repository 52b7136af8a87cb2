// Helpers of the command line's tests: parsing, running the program, temporary folders.
#include "command_line.h"

#include "app/parse_options.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>

namespace cmpg::test {
namespace {

std::string quoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text)
        result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

} // namespace

Options parse(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv{"cmpg-vk"};
    for (const std::string& a : arguments)
        argv.push_back(a.c_str());
    return parseOptions(int(argv.size()), argv.data());
}

std::optional<ErrorKind> parseCode(const std::vector<std::string>& arguments) {
    try {
        parse(arguments);
        return std::nullopt;
    } catch (const Error& e) {
        return e.kind;
    }
}

ProgramResult runProgram(const std::vector<std::string>& arguments, const std::vector<std::string>& environment) {
    const TemporaryFolder folder;
    std::string command;
    for (const std::string& e : environment)
        command += e.substr(0, e.find('=') + 1) + quoted(e.substr(e.find('=') + 1)) + " ";
    command += quoted(CMPG_BINARY);
    for (const std::string& a : arguments)
        command.append(" ").append(quoted(a));
    command.append(" >").append(quoted(folder / "out")).append(" 2>").append(quoted(folder / "err")).append(" </dev/null");
    const int status = std::system(command.c_str());
    ProgramResult result;
    result.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    result.out = readText(folder / "out");
    result.err = readText(folder / "err");
    return result;
}

RunningProgram::RunningProgram(const std::vector<std::string>& arguments, const std::string& folder, const std::vector<std::string>& environment,
                               const std::function<void()>& prepare)
    : folder_(folder) {
    std::filesystem::create_directories(folder);
    std::vector<std::string> all{CMPG_BINARY};
    all.insert(all.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& a : all)
        argv.push_back(a.data());
    argv.push_back(nullptr);
    const std::string out = folder + "/out", err = folder + "/err";
    pid_ = fork();
    if (pid_ != 0)
        return;
    for (const std::string& e : environment)
        setenv(e.substr(0, e.find('=')).c_str(), e.substr(e.find('=') + 1).c_str(), 1);
    if (prepare)
        prepare();
    if (!std::freopen(out.c_str(), "w", stdout) || !std::freopen(err.c_str(), "w", stderr))
        _exit(127);
    execv(CMPG_BINARY, argv.data());
    _exit(127);
}

RunningProgram::~RunningProgram() {
    if (running())
        kill(SIGKILL);
    wait();
}

bool RunningProgram::running() {
    if (status_ < 0 && waitpid(pid_, &status_, WNOHANG) != pid_)
        status_ = -1;
    return status_ < 0;
}

void RunningProgram::kill(int signal) { ::kill(pid_, signal); }

ProgramResult RunningProgram::wait() {
    if (status_ < 0)
        waitpid(pid_, &status_, 0);
    return {WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_), readText(folder_ + "/out"), readText(folder_ + "/err")};
}

void writeText(const std::string& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

std::string readText(const std::string& file) {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
}

} // namespace cmpg::test

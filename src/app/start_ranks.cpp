// The ranks of a run that mpirun started.
#include "app/start_ranks.h"

#include "app/module_file.h"
#include "mpi/mpi_entry.h"
#include "session/interrupt.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <string>
#include <thread>
#include <unistd.h>

namespace cmpg {
namespace {

MpiRanks* joined = nullptr;

struct Launcher {
    const char *sizeVariable, *rankVariable, *module, *package;
};
constexpr Launcher kLaunchers[] = {{"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK", "libcmpg-openmpi.so", "libopenmpi-dev"},
                                   {"PMI_SIZE", "PMI_RANK", "libcmpg-mpich.so", "libmpich-dev"}};

int number(const char* variable) {
    const char* const text = std::getenv(variable);
    return text ? std::atoi(text) : 0;
}

void silence() {
    const int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere < 0)
        return;
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    close(nowhere);
}

[[noreturn]] void refuse(const Launcher& launcher, const std::string& what, const std::string& cause) {
    if (number(launcher.rankVariable) > 0) { // the launcher ends all with the first that ends, and the message is that of rank 0
        silence();
        std::this_thread::sleep_for(std::chrono::seconds(1));
    }
    throw Error(ErrorKind::Device, "mpirun started " + std::to_string(number(launcher.sizeVariable)) + " ranks, and " + what, cause,
                std::string("build where ") + launcher.package + " is installed, or run without mpirun");
}

} // namespace

void startRanks() {
    const auto launcher = std::find_if(std::begin(kLaunchers), std::end(kLaunchers), [](const Launcher& l) { return number(l.sizeVariable) > 1; });
    if (launcher == std::end(kLaunchers))
        return;
    const std::optional<std::filesystem::path> file = findModule(launcher->module);
    if (!file)
        refuse(*launcher, std::string("the program has no module for its MPI: ") + launcher->module + " is missing",
               "it was not built or not installed; it was looked for in " + modulePlaces());
    void* const module = dlopen(file->c_str(), RTLD_NOW | RTLD_GLOBAL); // an MPI loads parts of its own that look for its symbols
    const auto start = module ? reinterpret_cast<MpiStart>(dlsym(module, kMpiStart)) : nullptr;
    if (!start) {
        const char* const reason = dlerror();
        refuse(*launcher, "its MPI cannot be loaded: " + std::string(reason ? reason : file->string()), "the library is missing, or of another version");
    }
    joined = start(&stopRequested);
    if (!joined)
        refuse(*launcher, "its MPI does not start", "the launcher is of another MPI than the library");
    setRanks(*joined);
    if (!joined->isRoot())
        silence();
}

void requireRanksFit(const Options& options) {
    if (ranks().size() == 1)
        return;
    const auto refuse = [](const std::string& what, const std::string& remedy) {
        throw Error(ErrorKind::Usage, what + " does not run on several ranks", {}, remedy);
    };
    const Command command = options.command;
    const bool informs = command == Command::Version || command == Command::ListDevices;
    const bool single = command == Command::Render || command == Command::Gradient;
    if (!informs && !single && command != Command::Optimize)
        refuse(commandName(command), "start it without mpirun");
    if (single && options.timeBudget)
        refuse("--time-budget", "the ranks' clocks differ: give --spp, --batches or --error-target instead");
    if (single && !options.displayServer.empty())
        refuse("--display-server", "start it without mpirun");
}

void reportRankFailure(const char* message) {
    if (joined)
        joined->reportFailure(message);
}

ExitStatus endRanks(ExitStatus status, bool failed) {
    if (joined && failed)
        joined->abort(int(status));
    if (joined)
        joined->finish();
    return status;
}

} // namespace cmpg

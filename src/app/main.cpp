// The program: parses, runs one command, turns errors into a message on stderr and an exit code.
#include "app/commands.h"
#include "app/parse_options.h"
#include "app/start_ranks.h"
#include "app/viewer_module.h"
#include "base/communicator.h"
#include "session/explain.h"
#include "session/interrupt.h"

#include <malloc.h>

#include <iostream>

namespace {

using namespace cmpg;

ExitStatus dispatch(const Options& options, Report& report) {
    switch (options.command) {
    case Command::Open:
        return runViewerModule(options);
    case Command::Render:
        return runRender(options, report);
    case Command::Gradient:
        return runGradient(options, report);
    case Command::Optimize:
        return runOptimize(options, report);
    case Command::Compare:
        return runCompare(options, report);
    case Command::Inspect:
        return runInspect(options, report);
    case Command::View:
        return runView(options, report);
    case Command::Guide:
        return runGuide(options, report);
    case Command::ListDevices:
        return runListDevices(options, report);
    case Command::Version:
        return runVersion(options, report);
    case Command::Tradeoff:
        return runTradeoff(options, report);
    case Command::None:
        break;
    }
    return ExitStatus::Usage;
}

ExitStatus run(int argc, char** argv) {
    Options options = parseOptions(argc, argv);
    requireRanksFit(options);
    if (!ranks().isRoot())
        options.displayServer.clear();
    Report report(options);
    const ExitStatus code = dispatch(options, report);
    if (options.json && options.command != Command::Open)
        std::cout << report.toJson().dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
    std::cout.flush();
    if (!std::cout)
        throw Error(ErrorKind::Output, "cannot write to standard output", "it was closed, or the disk is full");
    return code;
}

// Arrays as large as a texture come and go in every step. Pages that the system has taken back it clears before it gives them again, which took a fifth of a step
// of 2048 x 2048 texels: what is freed stays with the process.
void keepFreedMemory() {
#ifdef __GLIBC__
    mallopt(M_MMAP_MAX, 0);
    mallopt(M_TRIM_THRESHOLD, -1);
#endif
}

} // namespace

int main(int argc, char** argv) {
    keepFreedMemory();
    exitOnInterrupt();
    bool failed = false;
    const ExitStatus status = explainErrors([&] {
        try {
            startRanks();
            return run(argc, argv);
        } catch (const HelpRequested& help) {
            std::cout << help.text;
            return ExitStatus::Done;
        } catch (const std::exception& error) {
            failed = true;
            reportRankFailure(error.what());
            throw;
        }
    });
    return int(endRanks(status, failed));
}

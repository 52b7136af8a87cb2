// The program: parses, runs one command, turns errors into a message on stderr and an exit code.
#include "app/commands.h"
#include "app/interrupt.h"
#include "base/log.h"

#include <iostream>
#include <new>

namespace {

using namespace cmpg;

ExitCode dispatch(const Options& options, Report& report) {
    switch (options.command) {
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
    case Command::None:
        break;
    }
    return ExitCode::Usage;
}

ExitCode run(int argc, char** argv) {
    const Options options = parseOptions(argc, argv);
    setQuiet(options.quiet);
    Report report(options);
    const ExitCode code = dispatch(options, report);
    if (options.json)
        std::cout << report.toJson().dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
    std::cout.flush();
    if (!std::cout)
        throw Error(ExitCode::Output, "cannot write to standard output", "it was closed, or the disk is full");
    return code;
}

ExitCode explain(const Error& e) {
    std::cerr << "cmpg-vk: " << e.what() << '\n';
    if (!e.cause.empty())
        std::cerr << "  cause:  " << e.cause << '\n';
    const bool usage = e.code == ExitCode::Usage; // whose cause is the command line, as the message says
    if (!e.remedy.empty() || usage)
        std::cerr << "  remedy: " << (e.remedy.empty() ? "cmpg-vk --help lists the options with their values and defaults" : e.remedy) << '\n';
    return e.code;
}

} // namespace

int main(int argc, char** argv) {
    exitOnInterrupt();
    try {
        return int(run(argc, argv));
    } catch (const HelpRequested& help) {
        std::cout << help.text;
        return int(ExitCode::Done);
    } catch (const Error& e) {
        return int(explain(e));
    } catch (const std::bad_alloc&) {
        return int(explain(Error(ExitCode::Input, "the host ran out of memory", "the scene or an image is too large for this machine",
                                 "use smaller textures or images")));
    } catch (const std::exception& e) {
        return int(explain(Error(ExitCode::Numerical, std::string("internal error: ") + e.what(), "this is a mistake in the program",
                                 "report it with the output of --version and run.json")));
    }
}

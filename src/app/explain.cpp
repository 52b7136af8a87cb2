// What the user gets to read of an error, and the exit code it ends with.
#include "app/explain.h"

#include <iostream>
#include <new>

namespace cmpg {

ExitCode explain(const Error& error) {
    std::cerr << "cmpg-vk: " << error.what() << '\n';
    if (!error.cause.empty())
        std::cerr << "  cause:  " << error.cause << '\n';
    const bool usage = error.code == ExitCode::Usage; // whose cause is the command line, as the message says
    if (!error.remedy.empty() || usage)
        std::cerr << "  remedy: " << (error.remedy.empty() ? "cmpg-vk --help lists the options with their values and defaults" : error.remedy)
                  << '\n';
    return error.code;
}

ExitCode explainErrors(const std::function<ExitCode()>& work) {
    try {
        return work();
    } catch (const Error& error) {
        return explain(error);
    } catch (const std::bad_alloc&) {
        return explain(Error(ExitCode::Input, "the host ran out of memory", "the scene or an image is too large for this machine",
                             "use smaller textures or images"));
    } catch (const std::exception& error) {
        return explain(Error(ExitCode::Numerical, std::string("internal error: ") + error.what(), "this is a mistake in the program",
                             "report it with the output of --version and run.json"));
    }
}

} // namespace cmpg

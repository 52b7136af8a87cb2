// What the user gets to read of an error, and the exit code it ends with.
#include "session/explain.h"

#include <iostream>
#include <new>

namespace cmpg {

std::string withOptions(const std::string& remedy, std::span<const std::string> options) {
    std::string names;
    for (const std::string& option : options) {
        names.append(names.empty() ? "" : ", ");
        if (option == "inspect")
            names.append("cmpg-vk inspect SCENE");
        else
            names.append("--").append(option);
    }
    return names.empty() || remedy.empty() ? remedy : remedy + " (" + names + ")";
}

ExitStatus explain(const Error& error) {
    std::cerr << "cmpg-vk: " << error.what() << '\n';
    if (!error.cause.empty())
        std::cerr << "  cause:  " << error.cause << '\n';
    const bool usage = error.kind == ErrorKind::Usage; // whose cause is the command line, as the message says
    if (!error.remedy.empty() || usage)
        std::cerr << "  remedy: " << (error.remedy.empty() ? "cmpg-vk --help lists the options with their values and defaults" : remedyOf(error))
                  << '\n';
    return dynamic_cast<const CheckFailed*>(&error) ? ExitStatus::CheckFailed : exitStatusOf(error.kind);
}

ExitStatus explainErrors(const std::function<ExitStatus()>& work) {
    try {
        return work();
    } catch (const Error& error) {
        return explain(error);
    } catch (const std::bad_alloc&) {
        return explain(Error(ErrorKind::Input, "the host ran out of memory", "the scene or an image is too large for this machine",
                             "use smaller textures or images"));
    } catch (const std::exception& error) {
        return explain(Error(ErrorKind::Numerical, std::string("internal error: ") + error.what(), "this is a mistake in the program",
                             "report it with the output of --version and run.json"));
    }
}

} // namespace cmpg

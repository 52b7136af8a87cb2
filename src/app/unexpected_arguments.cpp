// Arguments that the parser has no place for, explained.
#include "app/unexpected_arguments.h"

#include "base/nearest_names.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace cmpg {
namespace {

constexpr const char* kHelp = "see cmpg-vk --help";

void addOptions(const CLI::App& app, std::vector<std::string>& names) {
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames())
            names.push_back("--" + name);
}

std::vector<const CLI::App*> commandsWith(const CLI::App& app, const std::string& option) {
    return app.get_subcommands([&](const CLI::App* sub) { return sub->get_option_no_throw(option) != nullptr; });
}

Error unknownOption(const CLI::App& app, const CLI::App* command, const std::string& option) {
    std::string others; // commands that have it
    for (const CLI::App* other : commandsWith(app, option))
        others += (others.empty() ? "" : ", ") + other->get_name();
    const std::string what = (command ? command->get_name() + " has" : std::string("there is")) + " no option " + option;
    if (!others.empty())
        return {ErrorKind::Usage, what, "it is one of " + others, command ? "see cmpg-vk " + command->get_name() + " --help" : kHelp};
    std::vector<std::string> known;
    addOptions(app, known);
    if (command)
        addOptions(*command, known);
    return {ErrorKind::Usage, what, "", didYouMean(std::move(known), option) + kHelp};
}

} // namespace

Error unexpectedArgument(const CLI::App& app) {
    const std::vector<std::string> arguments = app.remaining(true);
    const std::vector<CLI::App*> chosen = app.get_subcommands();
    const CLI::App* command = chosen.empty() ? nullptr : chosen.front();
    const auto option = std::find_if(arguments.begin(), arguments.end(), [](const std::string& a) { return a.size() > 1 && a.front() == '-'; });
    if (option != arguments.end())
        return unknownOption(app, command, option->substr(0, option->find('=')));
    const std::string word = arguments.empty() ? "" : arguments.front();
    return {ErrorKind::Usage, "'" + word + "' belongs to no option", command ? command->get_name() + " takes one file" : "",
            "an option that is given several times has its name before each value: --param A --param B"};
}

} // namespace cmpg

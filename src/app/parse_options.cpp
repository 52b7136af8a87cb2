// From arguments to options: the command, --config, what depends on the command.
#include "app/parse_options.h"

#include "app/declare_options.h"
#include "app/unexpected_arguments.h"
#include "base/error.h"

#include <cmpg/recovery.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

namespace cmpg {
namespace {

// The value of an option that has to be read before the rest is parsed, as the command line overrides what it brings.
std::string findValue(const std::string& option, int argc, const char* const* argv) {
    std::string value;
    for (int i = 1; i < argc; ++i) {
        const std::string arg = argv[i];
        if (arg == option && i + 1 < argc)
            value = argv[i + 1];
        if (arg.rfind(option + "=", 0) == 0)
            value = arg.substr(option.size() + 1);
    }
    return value;
}

void applyText(const std::string& text, const std::string& file, Options& options) {
    nlohmann::json config;
    try {
        config = nlohmann::json::parse(text);
    } catch (const nlohmann::json::exception& e) {
        throw Error(ErrorKind::Usage, "'" + file + "' is not JSON", e.what(), "give the path of a run.json");
    }
    applyConfig(config, options);
}

// Those of a run that has a checkpoint; there may be none, and one that another program made has no options.
void readResumed(const std::string& folder, Options& options) {
    std::optional<std::string> note;
    try {
        note = v1::Recovery::note(folder);
    } catch (const Error& error) { // options are not parsed yet, nor named as in other remedies
        throw Error(error.kind, error.what(), error.cause, "begin anew without --resume");
    }
    if (note && !note->empty())
        applyText(*note, folder, options);
}

void readConfig(const std::string& file, Options& options) {
    std::ifstream in(file);
    if (!in)
        throw Error(ErrorKind::Usage, "cannot read the configuration '" + file + "'", "the file does not exist or is not readable",
                    "give the path of a run.json");
    applyText({std::istreambuf_iterator<char>(in), {}}, file, options);
}

// What CLI11 says of options that have too many values, none, or one that means nothing to them; other texts as they are.
std::string inPlainWords(const std::string& text) {
    const auto between = [&](const std::string& before, const std::string& after) -> std::optional<std::pair<std::string, std::string>> {
        const std::size_t at = text.find(after, before.size());
        if (text.compare(0, before.size(), before) != 0 || at == std::string::npos)
            return {};
        return std::pair(text.substr(before.size(), at - before.size()), text.substr(at + after.size()));
    };
    if (const auto many = between("", ": At Most 1 required but received "))
        return many->first + " was given " + many->second + " times";
    if (const auto none = between("", ": 1 required "))
        return none->first + " lacks its value";
    if (const auto other = between("Could not convert: ", " = "))
        return other->first + (other->second.starts_with("--") ? " lacks its value: " + other->second + " comes next" : " does not take '" + other->second + "'");
    return text;
}

enum class Names { Nothing, Something, Command };

// What the arguments name: a command, or something else that is no option, such as a scene. Mistakes are somebody else's business.
Names namedBy(int argc, const char* const* argv) {
    Options ignored;
    CLI::App app;
    declareOptions(app, ignored);
    app.allow_extras();
    try {
        app.parse(argc, argv);
    } catch (const CLI::Error&) {
    }
    if (!app.get_subcommands().empty())
        return Names::Command;
    const std::vector<std::string> others = app.remaining();
    const bool any = std::any_of(others.begin(), others.end(), [](const std::string& other) { return !other.empty() && other.front() != '-'; });
    return any ? Names::Something : Names::Nothing;
}

} // namespace

Options parseOptions(int argc, const char* const* argv) {
    Options o;
    std::vector<const char*> arguments(argv, argv + argc);
    const Names named = namedBy(argc, argv);
    const std::string config = findValue("--config", argc, argv), resumed = findValue("--resume", argc, argv);
    if (!config.empty() || !resumed.empty()) {
        if (!resumed.empty())
            readResumed(resumed, o);
        if (!config.empty())
            readConfig(config, o);
        if (o.command != Command::None && named != Names::Command) // options of its own may follow
            arguments.insert(arguments.begin() + 1, commandName(o.command));
    } else if (named == Names::Something) {
        arguments.insert(arguments.begin() + 1, commandName(Command::Open));
    }
    CLI::App app("cmpg-vk: a differentiable path tracer in Vulkan compute", "cmpg-vk");
    app.get_formatter()->column_width(44);
    bool listDevices = false, version = false;
    declareQuestions(app, listDevices, version);
    declareOptions(app, o);
    app.require_subcommand(0, 1);
    try {
        app.parse(int(arguments.size()), arguments.data());
    } catch (const CLI::CallForHelp&) {
        const auto chosen = app.get_subcommands();
        if (!chosen.empty())
            throw HelpRequested{app.help() + "\nOptions common to all commands: cmpg-vk --help\n"};
        throw HelpRequested{app.help("", CLI::AppFormatMode::All)};
    } catch (const CLI::ExtrasError&) {
        if (named == Names::Something) { // a word that is no scene was to be a command
            o.command = Command::Open;
            validate(o);
        }
        throw unexpectedArgument(app);
    } catch (const CLI::ParseError& e) {
        throw Error(ErrorKind::Usage, inPlainWords(e.what()), "", "see cmpg-vk --help");
    }
    for (const auto& c : kCommands)
        if (c.value != Command::ListDevices && c.value != Command::Version && app.got_subcommand(c.name))
            o.command = c.value;
    if (listDevices)
        o.command = Command::ListDevices;
    if (version)
        o.command = Command::Version;
    if (o.output.empty())
        o.output = o.resume;
    validate(o);
    return o;
}

} // namespace cmpg

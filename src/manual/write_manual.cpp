// The manual page and the completion of bash, from the table of options. Runs while the program is built.
#include "app/declare_options.h"
#include "session/option_table.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>

namespace cmpg {
namespace {

// Of the man macros: what they would read as commands.
std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '\\')
            out += "\\e";
        else if (c == '-')
            out += "\\-";
        else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
            out += std::string("\\&") + c;
        else
            out += c;
    }
    return out;
}

std::vector<std::string> groupsOf(const CLI::App& app) {
    std::vector<std::string> groups;
    for (const CLI::Option* option : app.get_options())
        if (std::find(groups.begin(), groups.end(), option->get_group()) == groups.end())
            groups.push_back(option->get_group());
    return groups;
}

std::vector<const CLI::Option*> named(const CLI::App& app) {
    return app.get_options([](const CLI::Option* option) { return option->nonpositional(); });
}

void writeOptions(std::ostream& out, const CLI::App& app, const std::string& group) {
    for (const CLI::Option* option : named(app))
        if (option->get_group() == group && !option->check_lname("help")) {
            const std::string value = option->get_option_text();
            out << ".TP\n.B " << escaped(option->get_name(false, true)) << "\n" << (value.empty() ? "" : escaped(value) + "\n.br\n") << escaped(option->get_description()) << "\n";
        }
}

void writeManual(std::ostream& out, const CLI::App& app) {
    out << ".TH CMPG\\-VK 1 \"\" \"cmpg\\-vk " CMPG_VERSION "\"\n.SH NAME\ncmpg\\-vk \\- a differentiable path tracer that recovers materials from images\n"
           ".SH SYNOPSIS\n.B cmpg\\-vk\n.I SCENE\n.RI [ options ]\n.br\n.B cmpg\\-vk \\-\\-headless\n.I COMMAND INPUT\n.RI [ options ]\n"
           ".SH DESCRIPTION\nWithout a command, a window on a scene: render, differentiate and optimise live. A value in brackets is a default.\n";
    for (const std::string& group : groupsOf(app)) {
        out << ".SS " << escaped(group == "Options" ? "Without a scene" : group) << "\n"; // the parser's own
        writeOptions(out, app, group);
    }
    out << ".SH COMMANDS\n";
    for (const CLI::App* command : app.get_subcommands({})) {
        out << ".SS " << escaped(command->get_name()) << "\n" << escaped(command->get_description()) << ".\n";
        for (const std::string& group : groupsOf(*command))
            writeOptions(out, *command, group);
    }
    out << ".SH EXAMPLES AND EXIT CODES\n.nf\n" << escaped(app.get_footer()) << "\n.fi\n";
}

std::string wordsOf(const CLI::App& app) {
    std::string words;
    for (const CLI::Option* option : named(app))
        for (const std::string& name : option->get_lnames())
            words += " --" + name;
    return words;
}

// The values of an option that takes no others: "a|b|c  [a]". Capital letters and signs stand for something: "auto|FILE".
std::string choicesOf(const CLI::Option& option) {
    std::string text = option.get_option_text().substr(0, option.get_option_text().find("  ["));
    if (text.find('|') == std::string::npos || text.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-|") != std::string::npos)
        return {};
    std::replace(text.begin(), text.end(), '|', ' ');
    return text;
}

void writeCompletion(std::ostream& out, const CLI::App& app) {
    std::string headless, values, own; // `headless`: commands that open no window
    const std::string open = commandName(Command::Open);
    const auto addValues = [&](const CLI::App& from) {
        for (const CLI::Option* option : named(from))
            if (const std::string choices = choicesOf(*option); !choices.empty() && values.find("--" + option->get_lnames().front() + ")") == std::string::npos)
                values += "        --" + option->get_lnames().front() + ") COMPREPLY=($(compgen -W '" + choices + "' -- \"$word\")); return ;;\n";
    };
    addValues(app);
    for (const CLI::App* command : app.get_subcommands({})) {
        if (command->get_name() != open)
            headless += (headless.empty() ? "" : " ") + command->get_name();
        own += "            " + command->get_name() + ") options+='" + wordsOf(*command) + "' ;;\n";
        addValues(*command);
    }
    out << "# bash completion of cmpg-vk\n_cmpg_vk() {\n    local word=${COMP_WORDS[COMP_CWORD]} options='" << wordsOf(app)
        << "' w\n    case ${COMP_WORDS[COMP_CWORD-1]} in\n" << values << "    esac\n    local command= open='" << open << "'\n    for w in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n        case $w in\n"
        << own << "            --headless) open=; continue ;;\n            *) continue ;;\n        esac\n        command=$w\n        break\n    done\n    [[ -z $command && -n $open ]] && options+='"
        << wordsOf(*app.get_subcommand(open)) << "'\n    [[ $word == -* ]] && COMPREPLY=($(compgen -W \"$options\" -- \"$word\")) && return\n"
           "    mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n    [[ -z $command ]] && COMPREPLY+=($(compgen -W \"$open "
        << headless << "\" -- \"$word\"))\n}\ncomplete -o filenames -F _cmpg_vk cmpg-vk\n";
}

} // namespace
} // namespace cmpg

// write_manual MANUAL COMPLETION
int main(int argc, char** argv) {
    if (argc != 3)
        return 2;
    CLI::App app("cmpg-vk");
    cmpg::Options options;
    bool listDevices = false, version = false;
    cmpg::declareQuestions(app, listDevices, version);
    cmpg::declareOptions(app, options);
    std::ofstream manual(argv[1]), completion(argv[2]);
    cmpg::writeManual(manual, app);
    cmpg::writeCompletion(completion, app);
    return manual.flush() && completion.flush() ? 0 : 1;
}

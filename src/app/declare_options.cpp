// The table of options as the parser wants it: help, checks, fields.
#include "app/declare_options.h"

#include "session/option_table.h"
#include "session/option_values.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <limits>

namespace cmpg {
namespace {

constexpr const char* kFooter = R"(
Examples:
  cmpg-vk room.gltf --target ref.exr --param painting.baseColor                      a window: see gradients live
  cmpg-vk --headless render   room.gltf -o image.exr --spp 256
  cmpg-vk --headless gradient room.gltf --param painting.baseColor -o gradient.exr
  cmpg-vk --headless gradient room.gltf --param painting.baseColor --target ref.exr -o gradient.exr
  cmpg-vk --headless optimize room.gltf --param painting.baseColor --target ref.exr --set painting.baseColor=0.5 -o run
  cmpg-vk --headless compare  room.gltf --param painting.baseColor --target ref.exr --set painting.baseColor=0.5 --time 20 -o out
  cmpg-vk --headless view     gradient.exr -o gradient.png --signed

A run writes its effective configuration to run.json in the folder of its output; --config takes it back, and options on the
command line override it: --FLAG=false switches a flag off that it sets.

Exit codes: 0 done, 1 a check failed or a target was not reached, 2 usage, 3 scene, image or other input, 4 device,
            5 numerical failure, 6 output could not be written, 130 interrupted)";

template <class E, std::size_t N> CLI::CheckedTransformer oneOf(const EnumName<E> (&names)[N]) {
    std::vector<std::pair<std::string, E>> map;
    for (const auto& n : names)
        map.emplace_back(n.name, n.value);
    return CLI::CheckedTransformer(map);
}

template <class E, std::size_t N> std::string listOf(const EnumName<E> (&names)[N]) {
    std::string list;
    for (const auto& n : names)
        list += (list.empty() ? "" : "|") + std::string(n.name);
    return list;
}

// The parser turns -1 into the largest number, reads 010 as octal, and takes what does not fit into 64 bits for something that does.
template <class T> std::string requireWholeNumber(std::string& text) {
    T value = 0;
    const char* const end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data(), end, value);
    if (text.empty() || at != end || error != std::errc())
        return "needs a whole number from 0 to " + std::to_string(std::numeric_limits<T>::max()) + ", not '" + text + "'";
    text = std::to_string(value);
    return "";
}

// The parser takes an empty text for 0, and reads hexadecimal; what else is none it says itself.
std::string requireDecimal(const std::string& text) {
    return text.empty() || text.find_first_of("xX") != std::string::npos ? "needs a number, not '" + text + "'" : "";
}

// A number, or one with a unit.
CLI::Validator inUnit(Unit unit) {
    return {[unit](std::string& text) {
                const std::optional<double> value = unit == Unit::Share ? parseFraction(text) : parseSeconds(text);
                const std::string needs = unit == Unit::Share ? "a share, such as 1% or 0.01" : "a time, such as 90, 90s, 5min or 1h";
                if (!value)
                    return "needs " + needs + ", not '" + text + "'";
                text = exactDecimal(*value);
                return std::string();
            },
            ""};
}

template <class T> struct NumberOf { using Type = T; };
template <class T> struct NumberOf<std::optional<T>> { using Type = T; };

// Declares each option that it visits.
struct Declare {
    CLI::App& app;
    const char* heading = nullptr; // null: the parser's own

    template <class T> void operator()(const OptionSpec& option, T& field) const {
        if constexpr (std::is_same_v<T, bool>) {
            grouped(app.add_flag(nameOf(option), field, option.help));
        } else {
            CLI::Option* const added = add(option, field, option.value);
            using Number = typename NumberOf<T>::Type;
            if constexpr (std::is_unsigned_v<Number>)
                added->transform(CLI::Validator(requireWholeNumber<Number>, ""));
            if constexpr (std::is_floating_point_v<Number>)
                added->check(requireDecimal, "");
            if constexpr (std::is_same_v<T, std::vector<std::string>>)
                added->allow_extra_args(false);
        }
    }
    template <class T> void operator()(const OptionSpec& option, T& field, Unit unit) const { add(option, field, option.value)->transform(inUnit(unit)); }
    template <class T, class E, std::size_t N> void operator()(const OptionSpec& option, T& field, const EnumName<E> (&names)[N]) const {
        add(option, field, listOf(names))->transform(oneOf(names));
    }

  private:
    static std::string nameOf(const OptionSpec& option) { return (option.key == std::string("output") ? "-o,--" : "--") + std::string(option.key); }
    CLI::Option* grouped(CLI::Option* added) const { return heading ? added->group(heading) : added; }
    template <class T> CLI::Option* add(const OptionSpec& option, T& field, const std::string& value) const {
        const std::string initial = *option.initial ? std::string("  [") + option.initial + "]" : "";
        return grouped(app.add_option(nameOf(option), field, option.help)->option_text(value + initial));
    }
};

struct CommandHelp {
    Command command;
    const char *help, *input;
};
constexpr const char* kScene = "Scene, .gltf, .glb or .xml (Mitsuba)";
constexpr CommandHelp kCommandHelps[] = {
    {Command::Open, "A window on a scene; the word may be left away: cmpg-vk SCENE", kScene},
    {Command::Render, "Render an image: -o FILE.exr", kScene},
    {Command::Gradient, "Differentiate the image, or a loss of it", kScene},
    {Command::Optimize, "Recover parameters from target images: -o FOLDER", kScene},
    {Command::Compare, "Compare methods of sampling: equal time or equal samples, with a report: -o FOLDER", kScene},
    {Command::Tradeoff, "Measure which options trade speed for accuracy here, one at a time and in pairs, with a report: -o FOLDER", kScene},
    {Command::Inspect, "Cameras, materials, parameters, features and memory of a scene", kScene},
    {Command::View, "Make an EXR image into a PNG to look at: -o FILE.png", "Image"},
    {Command::Guide, "What a saved guide holds; -o FOLDER draws one of its cells", "Guide"},
};

const char* headingOf(OptionGroup group) {
    switch (group) {
    case OptionGroup::Sampling:
        return "Sampling (any command, before or after it)";
    case OptionGroup::Guide:
        return "Guide (render, gradient; optimize learns as it goes)";
    case OptionGroup::Scene:
        return "Scene (any command)";
    default:
        return "Running (any command)";
    }
}

} // namespace

void declareQuestions(CLI::App& app, bool& listDevices, bool& version) {
    app.set_help_flag("-h,--help", "This text; after a command, that command alone");
    app.add_flag("--list-devices", listDevices, "List Vulkan devices");
    app.add_flag("--version", version, "Version, device, driver and required device features");
}

void declareOptions(CLI::App& app, Options& options) {
    app.footer(kFooter);
    for (const OptionGroup group : kCommonGroups)
        visitGroup(group, options, Declare{app, headingOf(group)});
    for (const CommandHelp& command : kCommandHelps) {
        CLI::App* sub = app.add_subcommand(commandName(command.command), command.help);
        sub->fallthrough(); // common options may follow the command
        sub->add_option("input", options.input, command.input)->option_text(" ");
        for (const OptionGroup group : groupsOf(command.command))
            if (command.command != Command::Optimize || group != OptionGroup::Batches) // of its steps; run.json alone may say how many
                visitGroup(group, options, Declare{*sub});
    }
}

} // namespace cmpg

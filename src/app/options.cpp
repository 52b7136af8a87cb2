// The command line: every option, its help and its default.
#include "app/options.h"

#include "base/error.h"
#include "optimize/checkpoint.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

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
command line override it.

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

template <class E, std::size_t N, class Field>
CLI::Option* addEnum(CLI::App& app, const std::string& name, Field& field, const EnumName<E> (&names)[N], const char* initial,
                     const std::string& help) {
    return app.add_option(name, field, help)->transform(oneOf(names))->option_text(listOf(names) + "  [" + initial + "]");
}

// The parser turns -1 into the largest number.
std::string requireWholeNumber(const std::string& text) {
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
    return digits ? "" : "needs a whole number from 0, not '" + text + "'";
}

template <class Field> CLI::Option* addCount(CLI::App& app, const std::string& name, Field& field, const std::string& help) {
    return app.add_option(name, field, help)->check(requireWholeNumber, "");
}

// Text after an option's name: the kind of its value and the default.
std::string kind(const std::string& value, const std::string& initial) {
    return value + "  [" + initial + "]";
}

void addCommon(CLI::App& app, Options& o) {
    const std::string sampling = "Sampling (any command, before or after it)";
    addCount(app, "--spp", o.spp, "Samples per pixel of an image")->option_text(kind("N", "64; optimize, compare, --check, a step in a window: 16"))->group(sampling);
    addCount(app, "--spp-gradient", o.sppGradient, "Samples per pixel of a derivative pass")
        ->option_text(kind("N", "as --spp; optimize, also in compare: 4"))
        ->group(sampling);
    addCount(app, "--seed", o.seed, "Seed of all random numbers")->option_text(kind("N", "0"))->group(sampling);
    addEnum(app, "--sampler", o.sampler, kSamplers, "sobol", "Random numbers: Owen-scrambled Sobol points, or independent ones")
        ->group(sampling);
    addEnum(app, "--sampling", o.sampling, kSamplings, "auto",
            "How directions are drawn: from the materials alone; guided by light, by its derivatives, by both half and half, by both weighted "
            "by the path so far; or what training finds best")
        ->group(sampling);
    app.add_flag("--no-nee", o.noLightSampling, "No light sampling: emitters are only found by chance")->group(sampling);
    addEnum(app, "--pixel-sampling", o.pixelSampling, kPixelSamplings, "adjoint",
            "Reverse mode: the same samples everywhere, or more where the adjoint is large")
        ->group(sampling);
    app.add_flag("--positivize", o.positivize, "Derivative passes in two halves, one for each sign of the derivative")->group(sampling);
    addEnum(app, "--roulette", o.roulette, kRoulettes, "adjoint",
            "Reverse mode: end and split paths by what the guide expects of them, where it pays")
        ->group(sampling);

    const std::string guide = "Guide (render, gradient; optimize learns as it goes)";
    addCount(app, "--train", o.train, "Learning passes before the measured one, of as many samples each")
        ->option_text(kind("N", "0; compare: 8"))
        ->group(guide);
    app.add_option("--save-guide", o.saveGuide, "Write what was learned")->option_text("FILE")->group(guide);
    app.add_option("--load-guide", o.loadGuide, "Start from what an earlier run learned")->option_text("FILE")->group(guide);
    addCount(app, "--guide-memory", o.guideMemory, "Limit of the guide's own device memory; cells stop splitting there")
        ->option_text(kind("MiB", "64"))
        ->group(guide);

    const std::string scene = "Scene (any command)";
    addCount(app, "--width", o.width, "Width of the image in pixels")
        ->option_text(kind("N", "as the target or adjoint, else 512; --check: 128"))
        ->group(scene);
    addCount(app, "--height", o.height, "Height of the image in pixels")
        ->option_text(kind("N", "from the camera's aspect ratio"))
        ->group(scene);
    app.add_option("--camera", o.camera, "Camera of the scene")->option_text(kind("NAME", "the first"))->group(scene);
    addCount(app, "--max-depth", o.maxDepth, "Segments of a path; 1 = only lights seen directly")
        ->option_text(kind("N", "the scene's, else 8"))
        ->group(scene);
    app.add_option("--set", o.set,
                   "Give a parameter a value: P=0.5, P=r,g,b (fills every entry) or P=FILE (of its own size). P may be a glob. Repeats")
        ->option_text("P=VALUE|FILE")
        ->allow_extra_args(false)
        ->group(scene);

    const std::string run = "Running (any command)";
    app.add_option("--device", o.device, "Number or part of the name of a device of --list-devices")
        ->option_text(kind("DEVICE", "the best"))
        ->group(run);
    addCount(app, "--memory", o.memory, "Budget of transient device memory; results do not depend on it")
        ->option_text(kind("MiB", "1024"))
        ->group(run);
    app.add_flag("--all-features", o.allFeatures, "Kernels and buffers for all features, needed or not: the same results, slower; for comparison")
        ->group(run);
    app.add_option("-o,--output", o.output, "File or folder to write")->option_text("PATH")->group(run);
    app.add_option("--config", o.config, "Start from the options of a run.json")->option_text("FILE")->group(run);
    app.add_option("--display-server", o.displayServer,
                   "render, gradient, optimize: show images while they are made in a display such as tev, over the network. A slow or absent "
                   "display does not hold up the run")
        ->option_text(kind("HOST:PORT", "none"))
        ->group(run);
    app.add_flag("--json", o.json, "Print one JSON object on stdout, everything else on stderr")->group(run);
    app.add_flag("--quiet", o.quiet, "Print no configuration and no progress")->group(run);
    app.add_flag("--headless", o.headless, "No window: needs one of the commands, none of which opens one")->group(run);
}

void addTarget(CLI::App& app, Options& o) {
    app.add_option("--target", o.target,
                   "Image the loss compares with: .exr .hdr .png .jpg. Of one camera by CAMERA=FILE; repeats in optimize")
        ->option_text("[CAMERA=]FILE")
        ->allow_extra_args(false);
    addEnum(app, "--loss", o.loss, kLosses, "mse", "Mean over pixels and channels");
    app.add_option("--mask", o.mask, "Image whose mean channel weights the pixels of the loss")->option_text("FILE");
    app.add_option("--target-exposure", o.targetExposure, "Multiply targets by 2^E")->option_text(kind("E", "0"));
}

void addParameters(CLI::App& app, Options& o) {
    app.add_option("--param", o.param, "Parameter, as 'inspect' prints it, or a glob. Repeats")->option_text("P")->allow_extra_args(false);
}

void addDifferentiation(CLI::App& app, Options& o) {
    app.add_option(
           "--direction", o.direction,
           "Forward mode: image derivative when every entry grows alike (one), in proportion to its value (self), or along an image")
        ->option_text(kind("one|self|FILE", "one"));
    app.add_option("--adjoint", o.adjoint, "Reverse mode: adjoint^T . dI/dP for this image, in P's own shape")->option_text("FILE.exr");
}

void addOptimizer(CLI::App& app, Options& o) {
    addCount(app, "--steps", o.steps, "Steps")->option_text(kind("N", "200"));
    addEnum(app, "--optimizer", o.optimizer, kOptimizers, "adam", "Update rule");
    app.add_option("--rate", o.rate, "Learning rate, of all parameters or of one slot (baseColor, roughness ...). Repeats")
        ->option_text(kind("[SLOT=]RATE", "adam 0.02, normal 0.01; sgd 0.5, normal 0.25"))
        ->allow_extra_args(false);
    addEnum(app, "--schedule", o.schedule, kSchedules, "constant", "How the rate falls");
    app.add_option("--final-rate", o.finalRate, "Factor of the rate at the last step, under a schedule")
        ->option_text(kind("F", "0.1"));
    addCount(app, "--warm-up", o.warmUp, "First steps, which learn the guide and leave the parameters alone")->option_text(kind("N", "0"));
    addCount(app, "--freeze", o.freeze, "Step from which on the guide stays as it is")->option_text(kind("N", "never"));
    app.add_option("--forgetting", o.forgetting, "What the guide keeps of older steps, each step")->option_text(kind("F", "0.9"));
    app.add_option("--total-variation", o.totalVariation, "Weight of the total variation of textures in the loss")
        ->option_text(kind("W", "0"));
}

void addCheckpoints(CLI::App& app, Options& o) {
    app.add_option("--checkpoint-every", o.checkpointEvery, "Keep all that going on needs after so many steps, or so much time (s, m or h); 0: never")
        ->option_text(kind("N|T", "10m"));
    app.add_option("--resume", o.resume,
                   "Go on with the run of a folder, from its last checkpoint or from the beginning. The scene and all options may be left away; "
                   "what is given must agree with the run")
        ->option_text("FOLDER");
}

void addComparison(CLI::App& app, Options& o) {
    app.add_option("--methods", o.methods,
                   "Comma-separated: plain, primal, differential, uniform, conditional, ours; each with parts, as in "
                   "conditional+pixels+roulette: pixels, roulette, positivize, nonee, independent")
        ->option_text(kind("LIST", "plain,primal,conditional,ours"));
    app.add_option("--mode", o.mode,
                   "Comma-separated: the derivative image (forward), the gradient of an adjoint or a target's loss (reverse), a whole "
                   "recovery from a target (optimize)")
        ->option_text(kind("LIST", "reverse"));
    app.add_option("--time", o.time, "Equal time: seconds of passes or steps for each method. Without it, equal samples")->option_text("T");
    addCount(app, "--seeds", o.seeds, "Passes of each method, or the fewest under --time; optimize: repetitions")
        ->option_text(kind("K", "16; under --time: 4; optimize: 1"));
    app.add_option("--reference", o.reference,
                   "What is right: made by the most efficient method (auto), or an image. optimize: the scene's own values, or an image")
        ->option_text(kind("auto|FILE", "auto"));
    app.add_option("--reference-time", o.referenceTime, "Most seconds for an automatic reference")
        ->option_text(kind("T", "twice all measured passes"));
    addCount(app, "--adjoint-spp", o.adjointSpp, "Samples per pixel of the image whose loss gives the adjoint of --target")
        ->option_text(kind("N", "256"));
}

void addLayers(CLI::App& app, Options& o) {
    app.add_option("--layers", o.layers, "What the camera sees first, and what the guide does there, as layers of this file; not in reverse mode")
        ->option_text("FILE.exr");
}

CLI::App* addCommand(CLI::App& app, Options& o, Command command, const std::string& help, const std::string& input) {
    CLI::App* sub = app.add_subcommand(commandName(command), help);
    sub->fallthrough(); // common options may follow the command
    sub->add_option("input", o.input, input)->option_text(" ");
    return sub;
}

void addCommands(CLI::App& app, Options& o) {
    const std::string scene = "Scene, .gltf or .glb";
    CLI::App* open = addCommand(app, o, Command::Open, "A window on a scene; the word may be left away: cmpg-vk SCENE", scene);
    addParameters(*open, o);
    addTarget(*open, o);
    addOptimizer(*open, o);

    CLI::App* render = addCommand(app, o, Command::Render, "Render an image: -o FILE.exr", scene);
    addLayers(*render, o);

    CLI::App* gradient = addCommand(app, o, Command::Gradient, "Differentiate the image, or a loss of it", scene);
    addParameters(*gradient, o);
    addDifferentiation(*gradient, o);
    addTarget(*gradient, o);
    addLayers(*gradient, o);
    gradient->add_flag("--check", o.check, "Compare the forward gradient with finite differences; exit code 1 if they disagree");

    CLI::App* optimize = addCommand(app, o, Command::Optimize, "Recover parameters from target images: -o FOLDER", scene);
    addParameters(*optimize, o);
    addTarget(*optimize, o);
    addOptimizer(*optimize, o);
    addCheckpoints(*optimize, o);

    CLI::App* compare =
        addCommand(app, o, Command::Compare, "Compare ways of sampling: equal time or equal samples, with a report: -o FOLDER", scene);
    addParameters(*compare, o);
    addComparison(*compare, o);
    addDifferentiation(*compare, o);
    addTarget(*compare, o);
    addOptimizer(*compare, o);

    CLI::App* inspect = addCommand(app, o, Command::Inspect, "Cameras, materials, parameters, features and memory of a scene", scene);
    inspect->add_option("--param", o.param, "Parameter that is to be differentiable, for features and memory. Repeats")
        ->option_text("P")
        ->allow_extra_args(false);

    CLI::App* view = addCommand(app, o, Command::View, "Make an EXR image into a PNG to look at: -o FILE.png", "Image");
    view->add_option("--layer", o.layer, "Layer of an EXR file with several, such as --layers writes")->option_text("NAME");
    view->add_flag("--signed", o.isSigned, "Signed data: blue below zero, orange above, with the scale");
    view->add_option("--exposure", o.exposure, "Multiply by 2^E")->option_text(kind("E", "0"));
    view->add_option("--scale", o.scale, "Signed: the value of the deepest colour")->option_text(kind("S", "99.5th percentile of |value|"));

    CLI::App* guide = addCommand(app, o, Command::Guide, "What a saved guide holds; -o FOLDER draws one of its cells", "Guide");
    guide->add_flag("--validate", o.validateGuide, "Check all that must hold; exit code 1 if something does not");
    guide->add_flag("--csv", o.csv, "Print one line per cell instead");
    addCount(*guide, "--cell", o.cell, "Cell to draw")->option_text(kind("N", "the one with most records"));
    guide->add_option("--weights", o.weights, "Weights of light and of its derivatives in the mixture that is drawn")
        ->option_text(kind("L,D", "1,1"));
}

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
        throw Error(ExitCode::Usage, "'" + file + "' is not JSON", e.what(), "give the path of a run.json");
    }
    applyConfig(config, options);
}

// Those of a run that has a checkpoint; there may be none.
void readResumed(const std::string& folder, Options& options) {
    std::vector<std::string> refused;
    if (const auto checkpoint = findCheckpoint(folder, refused))
        applyText(checkpoint->config, folder, options);
    else if (!refused.empty())
        throw Error(ExitCode::Input, "no checkpoint in '" + folder + "' can be used: " + refused.front(), "",
                    "begin anew without --resume");
}

void readConfig(const std::string& file, Options& options) {
    std::ifstream in(file);
    if (!in)
        throw Error(ExitCode::Usage, "cannot read the configuration '" + file + "'", "the file does not exist or is not readable",
                    "give the path of a run.json");
    applyText({std::istreambuf_iterator<char>(in), {}}, file, options);
}

enum class Names { Nothing, Something, Command };

// What the arguments name: a command, or something else that is no option, such as a scene. Mistakes are somebody else's business.
Names namedBy(int argc, const char* const* argv) {
    Options ignored;
    CLI::App app;
    addCommon(app, ignored);
    addCommands(app, ignored);
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

const char* commandName(Command command) {
    for (const auto& c : kCommands)
        if (c.value == command)
            return c.name;
    return "";
}

std::uint32_t Options::effectiveSpp() const {
    if (spp)
        return *spp;
    return command == Command::Open || command == Command::Optimize || command == Command::Compare || check ? 16 : 64;
}

std::uint32_t Options::effectiveSppGradient() const {
    if (sppGradient)
        return *sppGradient;
    return command == Command::Open || command == Command::Optimize || (command == Command::Compare && mode == "optimize") ? 4 : effectiveSpp();
}

std::uint32_t Options::effectiveTrain() const {
    return train.value_or(command == Command::Compare ? 8 : 0);
}

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
    app.set_help_flag("-h,--help", "This text; after a command, that command alone");
    app.get_formatter()->column_width(44);
    app.footer(kFooter);
    bool listDevices = false, version = false;
    app.add_flag("--list-devices", listDevices, "List Vulkan devices");
    app.add_flag("--version", version, "Version, device, driver and required device features");
    addCommon(app, o);
    addCommands(app, o);
    app.require_subcommand(0, 1);
    try {
        app.parse(int(arguments.size()), arguments.data());
    } catch (const CLI::CallForHelp&) {
        const auto chosen = app.get_subcommands();
        if (!chosen.empty())
            throw HelpRequested{app.help() + "\nOptions common to all commands: cmpg-vk --help\n"};
        throw HelpRequested{app.help("", CLI::AppFormatMode::All)};
    } catch (const CLI::ParseError& e) {
        throw Error(ExitCode::Usage, e.what(), "", "see cmpg-vk --help");
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

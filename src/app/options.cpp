// Every option of the command line, its help and its default.
#include "app/option_declarations.h"
#include "app/option_values.h"
#include "app/options.h"

#include <CLI/CLI.hpp>

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

// A number, or what `parse` makes of one with a unit.
template <class Field>
CLI::Option* addQuantity(CLI::App& app, const std::string& name, Field& field, std::optional<double> (*parse)(const std::string&),
                         const std::string& needs, const std::string& help) {
    const auto toNumber = [parse, needs](std::string& text) {
        const std::optional<double> value = parse(text);
        if (!value)
            return "needs " + needs + ", not '" + text + "'";
        text = exactDecimal(*value);
        return std::string();
    };
    return app.add_option(name, field, help)->transform(CLI::Validator(toNumber, ""));
}

template <class Field> CLI::Option* addSeconds(CLI::App& app, const std::string& name, Field& field, const std::string& help) {
    return addQuantity(app, name, field, parseSeconds, "a time, such as 90, 90s, 5min or 1h", help);
}

// Text after an option's name: the kind of its value and the default.
std::string kind(const std::string& value, const std::string& initial) {
    return value + "  [" + initial + "]";
}

void addCommon(CLI::App& app, Options& o) {
    const std::string sampling = "Sampling (any command, before or after it)";
    addEnum(app, "--quality", o.quality, kQualities, "balanced",
            "Defaults that trade error for time: a quarter of the samples and half the depth; or four times the samples and twice the depth")
        ->group(sampling);
    addCount(app, "--spp", o.spp, "Samples per pixel of an image")->option_text(kind("N", "64; optimize, compare, tradeoff, --check, a step in a window: 16"))->group(sampling);
    addCount(app, "--spp-gradient", o.sppGradient, "Samples per pixel of a derivative pass")
        ->option_text(kind("N", "as --spp; optimize, also in compare, and tradeoff: 4"))
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
        ->option_text(kind("N", "0; compare, tradeoff: 8"))
        ->group(guide);
    addCount(app, "--train-spp", o.trainSpp, "Samples per pixel of a learning pass")
        ->option_text(kind("N", "as the measured pass; of several batches: 8"))
        ->group(guide);
    app.add_option("--save-guide", o.saveGuide, "Write what was learned")->option_text("FILE")->group(guide);
    app.add_option("--load-guide", o.loadGuide, "Start from what an earlier run learned")->option_text("FILE")->group(guide);
    addCount(app, "--guide-memory", o.guideMemory, "Limit of the guide's own device memory; cells stop splitting there")
        ->option_text(kind("MiB", "64"))
        ->group(guide);
    app.add_option("--guide-share", o.guideShare, "Of directions, drawn from the guide where it knows something; the rest from the material")
        ->option_text(kind("F", "0.5"))
        ->group(guide);
    addCount(app, "--cell-records", o.cellRecords, "Records of a pass from which a cell of the guide splits")->option_text(kind("N", "6000"))->group(guide);
    app.add_option("--direction-share", o.directionShare, "Share of a cell's light or derivatives from which a quadrant of directions splits")
        ->option_text(kind("F", "0.01"))
        ->group(guide);
    app.add_option("--forgetting", o.forgetting, "What the guide keeps of older passes or steps, each time")->option_text(kind("F", "0.9"))->group(guide);
    app.add_option("--roulette-effort", o.rouletteEffort,
                   "A path whose expected contribution is this share of the average goes on once: less makes more copies")
        ->option_text(kind("F", "0.3"))
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
    app.add_option("--environment", o.environment, "Latitude-longitude picture of the surroundings, in place of the scene's own, or of none")
        ->option_text("FILE")
        ->group(scene);
    app.add_option("--environment-rotation", o.environmentRotation, "Turn that picture about +Y, counter-clockwise seen from above")
        ->option_text(kind("DEGREES", "0"))
        ->group(scene);
    app.add_option("--define", o.define, "Value of a variable of a Mitsuba scene, in place of its default. Repeats")
        ->option_text("NAME=VALUE")
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

void addBudget(CLI::App& app, Options& o) {
    addQuantity(app, "--error-target", o.errorTarget, parseFraction, "a share, such as 1% or 0.01",
                "Sample until |standard error| / |estimate| is this small, over all pixels or texels; optimize: of the gradient of each step. Exit "
                "code 1 if it is not within the samples (--spp, or --spp-gradient) or the time allowed")
        ->option_text("E%");
    addSeconds(app, "--time-budget", o.timeBudget, "Sample for so long, loading and learning included; optimize: steps")->option_text("T");
}

void addBatches(CLI::App& app, Options& o) {
    addBudget(app, o);
    addCount(app, "--batches", o.batches, "Divide the samples among so many batches with random numbers of their own, whose spread tells the error")
        ->option_text(kind("N", "8 with an error target or a time budget, else none"));
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
    addEnum(app, "--optimizer", o.optimizer, kOptimizers, "auto",
            "Update rule; auto: gauss-newton for base colours, metallic, specular and light where the loss is a squared one, else adam");
    app.add_option("--rate", o.rate, "Learning rate, of all parameters or of one slot (baseColor, roughness ...). Repeats")
        ->option_text(kind("[SLOT=]RATE", "adam 0.02, normal 0.01; sgd 0.5, normal 0.25"))
        ->allow_extra_args(false);
    addEnum(app, "--schedule", o.schedule, kSchedules, "constant", "How the rate falls");
    app.add_option("--final-rate", o.finalRate, "Factor of the rate at the last step, under a schedule")
        ->option_text(kind("F", "0.1"));
    addCount(app, "--spp-difference", o.sppDifference,
             "Samples per pixel by which a step brings the image of the step before up to date; 0: every step renders its own of --spp")
        ->option_text(kind("N", "8"));
    addCount(app, "--views-per-step", o.viewsPerStep, "Of several targets so many a step, in random order, each once before any again; 0: all")->option_text(kind("N", "0"));
    addCount(app, "--warm-up", o.warmUp, "First steps, which learn the guide and leave the parameters alone")->option_text(kind("N", "0"));
    addCount(app, "--freeze", o.freeze, "Step from which on the guide stays as it is")->option_text(kind("N", "never"));
    addCount(app, "--stop-after", o.stopAfter, "End after so many of the steps, with the schedule of all")->option_text(kind("N", "--steps"));
    app.add_option("--prior", o.prior,
                   "How alike neighbouring texels of slots from 0 to 1 are before any image is seen: differences are as likely as exp(-B |d|), beside "
                   "images trusted to 5 % of their mean; 0: no prior")
        ->option_text(kind("B", "8"));
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
    addSeconds(app, "--time", o.time, "Equal time: of passes or steps for each method. Without it, equal samples")->option_text("T");
    addCount(app, "--seeds", o.seeds, "Passes of each method, or the fewest under --time; optimize: repetitions")
        ->option_text(kind("K", "16; under --time: 4; optimize: 1"));
    app.add_option("--reference", o.reference,
                   "What is right: made by the most efficient method (auto), or an image. optimize: the scene's own values, or an image")
        ->option_text(kind("auto|FILE", "auto"));
    addSeconds(app, "--reference-time", o.referenceTime, "Most time for an automatic reference")
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
    const std::string scene = "Scene, .gltf, .glb or .xml (Mitsuba)";
    CLI::App* open = addCommand(app, o, Command::Open, "A window on a scene; the word may be left away: cmpg-vk SCENE", scene);
    addParameters(*open, o);
    addTarget(*open, o);
    addOptimizer(*open, o);

    CLI::App* render = addCommand(app, o, Command::Render, "Render an image: -o FILE.exr", scene);
    addLayers(*render, o);
    addBatches(*render, o);

    CLI::App* gradient = addCommand(app, o, Command::Gradient, "Differentiate the image, or a loss of it", scene);
    addParameters(*gradient, o);
    addDifferentiation(*gradient, o);
    addTarget(*gradient, o);
    addLayers(*gradient, o);
    addBatches(*gradient, o);
    gradient->add_flag("--check", o.check, "Compare the forward gradient with finite differences; exit code 1 if they disagree");

    CLI::App* optimize = addCommand(app, o, Command::Optimize, "Recover parameters from target images: -o FOLDER", scene);
    addParameters(*optimize, o);
    addTarget(*optimize, o);
    addOptimizer(*optimize, o);
    addBudget(*optimize, o);
    addCheckpoints(*optimize, o);

    CLI::App* compare =
        addCommand(app, o, Command::Compare, "Compare ways of sampling: equal time or equal samples, with a report: -o FOLDER", scene);
    addParameters(*compare, o);
    addComparison(*compare, o);
    addDifferentiation(*compare, o);
    addTarget(*compare, o);
    addOptimizer(*compare, o);

    CLI::App* tradeoff = addCommand(app, o, Command::Tradeoff,
                                    "Measure which options trade speed for accuracy here, one at a time and in pairs, with a report: -o FOLDER", scene);
    addParameters(*tradeoff, o);
    addDifferentiation(*tradeoff, o);
    addTarget(*tradeoff, o);
    addSeconds(*tradeoff, "--time", o.time, "Of the whole measurement, about")->option_text(kind("T", "30min"));
    addCount(*tradeoff, "--seeds", o.seeds, "Trainings of each setting, with random numbers of their own")->option_text(kind("K", "3"));

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

} // namespace

void declareOptions(CLI::App& app, Options& options) {
    app.footer(kFooter);
    addCommon(app, options);
    addCommands(app, options);
}

} // namespace cmpg

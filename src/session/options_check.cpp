// What makes sense together among the options, however they were given.
#include "session/options.h"

#include "base/error.h"
#include "base/nearest_names.h"
#include "imaging/display_stream.h"
#include "scene/file_io.h"
#include "scene/scene_file.h"
#include "session/library_options.h"
#include "session/parameter_values.h"
#include "session/refuse.h"

#include <cstdio>
#include <filesystem>

namespace cmpg {
namespace {

void requirePositive(const std::optional<std::uint32_t>& value, const char* name, std::uint32_t highest) {
    if (value && (*value == 0 || *value > highest))
        refuse(std::string(name) + " must be from 1 to " + std::to_string(highest) + ", not " + std::to_string(*value));
}

void requireFinite(double value, const char* name, double lowest, double highest) {
    if (!(value >= lowest && value <= highest)) {
        char range[64];
        std::snprintf(range, sizeof range, " must be from %g to %g", lowest, highest);
        refuse(name + std::string(range));
    }
}

// Images and derivatives have a guide to save only where one is learned or loaded; an optimisation always learns one.
void validateSavedGuide(const Options& o) {
    if (o.saveGuide.empty() || (o.command != Command::Render && o.command != Command::Gradient))
        return;
    if (o.effectiveTrain() == 0 && o.loadGuide.empty())
        refuse("--save-guide has nothing to save: no guide is learned", "add --train N, the number of learning passes, or --load-guide FILE");
    if (o.output.empty())
        refuse("--save-guide has nothing to save: --check alone learns no guide", "add -o FILE.exr");
}

void validateBudget(const Options& o) {
    if (o.errorTarget)
        requireFinite(*o.errorTarget, "--error-target", 1e-6f, 100);
    if (o.timeBudget)
        requireFinite(*o.timeBudget, "--time-budget", 1e-3f, 1e7f);
    const std::uint32_t batches = o.effectiveBatches();
    if (batches == 0)
        return;
    if (batches < kFewestBatches || batches > kMostBatches)
        refuse("--batches must be from " + std::to_string(kFewestBatches) + " to " + std::to_string(kMostBatches));
    const bool image = o.command == Command::Render;
    const std::uint32_t samples = image ? o.effectiveSpp() : o.effectiveSppGradient();
    const std::string option = image ? "--spp" : "--spp-gradient";
    if (samples < batches)
        refuse("an error is told from at least " + std::to_string(batches) + " samples per pixel, not " + std::to_string(samples), "raise " + option);
    if (!o.hasBudget() && samples % batches != 0)
        refuse(option + " must be a multiple of --batches");
    if (!o.layers.empty())
        refuse("--layers does not go with --batches, --error-target or --time-budget");
    if (o.check)
        refuse("--check does not go with --batches, --error-target or --time-budget");
}

void validateGradient(const Options& o) {
    if (o.param.empty())
        refuse("gradient needs --param", "'inspect SCENE' lists the parameters");
    if (!o.adjoint.empty() && !o.target.empty())
        refuse("--adjoint and --target exclude each other", "--target derives its adjoint from the loss");
    if (o.target.size() > 1)
        refuse("gradient takes one --target", "several are for optimize, and for compare --mode optimize");
    if (o.check && o.isReverse())
        refuse("--check compares the forward gradient image: it takes neither --adjoint nor --target");
    if (o.isReverse() && o.direction != "one")
        refuse("--direction is of forward mode: it goes with neither --adjoint nor --target");
    if (o.output.empty() && !o.check)
        refuse("gradient needs -o FILE.exr");
    if (!o.layers.empty() && o.isReverse())
        refuse("--layers belongs to images: it goes with neither --adjoint nor --target", "leave them away: forward mode draws by the same weights");
    if (!o.layers.empty() && o.positivize)
        refuse("--layers and --positivize exclude each other: the halves have mixtures of their own");
    if (!o.layers.empty() && o.output.empty())
        refuse("--layers needs -o FILE.exr: --check alone makes no image");
}

void validateSteps(const Options& o) {
    if (o.recovery.steps == 0 || o.recovery.steps > 10'000'000)
        refuse("--steps must be from 1 to 10000000");
    requireFinite(o.recovery.finalRate, "--final-rate", 0, 1);
    if (o.recovery.schedule == Schedule::Exponential && o.recovery.finalRate == 0)
        refuse("--final-rate must be above 0 with an exponential schedule, which never gets to 0");
    requireFinite(o.recovery.totalVariation, "--total-variation", 0, 1e6f);
    requireFinite(o.recovery.prior, "--prior", 0, 1e6f);
    requirePositive(o.stopAfter, "--stop-after", 10'000'000);
    requirePositive(o.sppPictures, "--spp-pictures", 1u << 24);
}

void validateOptimize(const Options& o) {
    if (o.param.empty())
        refuse("optimize needs --param", "'inspect SCENE' lists the parameters");
    if (o.target.empty())
        refuse("optimize needs --target");
    if (o.output.empty())
        refuse("optimize needs -o FOLDER");
    validateSteps(o);
    checkpointInterval(o); // throws
    std::error_code ignored; // of folders that are not there
    if (!o.resume.empty() && std::filesystem::path(o.output) != o.resume && !std::filesystem::equivalent(o.output, o.resume, ignored))
        refuse("--resume and -o name different folders", "leave -o away");
}

std::string commandLike(const std::string& word) {
    std::vector<std::string> names;
    for (const auto& command : kCommands)
        if (command.value != Command::ListDevices && command.value != Command::Version) // flags
            names.emplace_back(command.name);
    return didYouMean(std::move(names), word);
}

void validateOpen(const Options& o) {
    if (!isSceneName(o.input) && !fileExists(o.input))
        refuse("'" + o.input + "' is neither a command nor a scene", commandLike(o.input) + "see cmpg-vk --help");
    if (o.headless)
        refuse("--headless opens no window, and no command says what else to do",
               "name a command: cmpg-vk --headless render " + o.input + " -o image.exr; see cmpg-vk --help");
    if (o.target.size() > 1)
        refuse("a window takes one --target", "several are for optimize, and for compare --mode optimize");
    validateSteps(o);
}

// What commands that measure a pass or a step have in common.
void validateMeasurement(const Options& o, const std::string& command) {
    if (o.param.empty())
        refuse(command + " needs --param", "'inspect SCENE' lists the parameters");
    if (o.output.empty())
        refuse(command + " needs -o FOLDER");
    if (!o.adjoint.empty() && !o.target.empty())
        refuse("--adjoint and --target exclude each other", "--target derives its adjoint from the loss");
    if (o.time)
        requireFinite(*o.time, "--time", 1e-3f, 1e7f);
}

void validateCompare(const Options& o) {
    validateMeasurement(o, "compare");
    if (o.referenceTime)
        requireFinite(*o.referenceTime, "--reference-time", 1e-3f, 1e7f);
    requirePositive(o.seeds, "--seeds", 1'000'000);
    constexpr std::uint32_t kFewest = 4;
    if (o.seeds && *o.seeds < kFewest && o.mode != "optimize")
        refuse("--seeds must be at least 4 for derivatives: fewer passes do not show their variance");
    requirePositive(o.adjointSpp, "--adjoint-spp", 1u << 24);
    validateSteps(o);
}

void validateTradeoff(const Options& o) {
    validateMeasurement(o, "tradeoff");
    if (o.target.size() > 1)
        refuse("tradeoff takes one --target", "several are for optimize, and for compare --mode optimize");
    requirePositive(o.seeds, "--seeds", 1000);
}

} // namespace

void validate(const Options& o) {
    if (o.command == Command::ListDevices || o.command == Command::Version)
        return;
    if (o.command == Command::None)
        refuse("no command given",
               "a scene opens a window; commands are render, gradient, optimize, compare, tradeoff, inspect, view, guide; see cmpg-vk --help");
    if (o.input.empty() && !o.resume.empty())
        refuse("'" + o.resume + "' has no checkpoint that says which scene it is of", "give the scene and the options of the run beside --resume, or begin anew without it");
    if (o.input.empty())
        refuse(commandName(o.command) + std::string(o.command == Command::View    ? " needs an image"
                                                        : o.command == Command::Guide ? " needs a guide"
                                                                                      : " needs a scene"));

    constexpr std::uint32_t kMaxSamples = 1u << 24; // counts stay exact in float
    constexpr std::uint32_t kMaxEdge = 1u << 15;
    requirePositive(o.spp, "--spp", kMaxSamples);
    requirePositive(o.sppGradient, "--spp-gradient", kMaxSamples);
    if (o.recovery.sppDifference > kMaxSamples || o.recovery.sppDifference == 1)
        refuse("--spp-difference takes 0, or at least 2: an image has two halves", "use 2");
    requirePositive(o.width, "--width", kMaxEdge);
    requirePositive(o.height, "--height", kMaxEdge);
    requirePositive(o.maxDepth, "--max-depth", 1024);
    if (o.memory < 16 || o.memory > (1u << 22))
        refuse("--memory must be from 16 to 4194304 MiB");
    if (o.effectiveTrain() > 100000)
        refuse("--train must be at most 100000 passes");
    if (o.guideMemory < 1 || o.guideMemory > 4096)
        refuse("--guide-memory must be from 1 to 4096 MiB");
    for (const std::string& s : o.set)
        if (s.find('=') == std::string::npos || s.front() == '=')
            refuse("--set takes P=VALUE or P=FILE, not '" + s + "'");
    for (const std::string& t : o.texture)
        parseTexture(t); // throws
    for (const std::string& d : o.define)
        if (d.find('=') == std::string::npos || d.front() == '=')
            refuse("--define takes NAME=VALUE, not '" + d + "'");
    if (!o.filter.empty())
        v1::ReconstructionFilter::parse(o.filter); // throws
    if (o.environmentRotation) {
        requireFinite(*o.environmentRotation, "--environment-rotation", -36000, 36000);
        if (o.environment.empty())
            refuse("--environment-rotation needs --environment FILE", "the rotation of a scene's own surroundings stands in the scene");
    }
    if (!o.displayServer.empty())
        DisplayStream::requireAddress(o.displayServer);
    requirePositive(o.trainSpp, "--train-spp", kMaxSamples);
    requireFinite(o.guideShare, "--guide-share", 0, 0.95f); // materials must be able to draw what the guide never does
    if (o.cellRecords < 1 || o.cellRecords > (1u << 30))
        refuse("--cell-records must be from 1 to 1073741824");
    requireFinite(o.directionShare, "--direction-share", 1e-4, 1);
    requireFinite(o.forgetting, "--forgetting", 0, 1);
    requireFinite(o.rouletteEffort, "--roulette-effort", 0.01f, 100);
    requireFinite(o.targetExposure, "--target-exposure", -64, 64);
    requireFinite(o.exposure, "--exposure", -64, 64);
    if (o.scale)
        requireFinite(*o.scale, "--scale", 1e-30f, 1e30f);

    validateBudget(o);
    if (o.command == Command::Open)
        validateOpen(o);
    if (o.command == Command::Gradient)
        validateGradient(o);
    if (o.command == Command::Optimize)
        validateOptimize(o);
    if (o.command == Command::Compare)
        validateCompare(o);
    if (o.command == Command::Tradeoff)
        validateTradeoff(o);
    validateSavedGuide(o);
    if ((o.command == Command::Render || o.command == Command::View) && o.output.empty())
        refuse(commandName(o.command) + std::string(" needs -o FILE"));
}

} // namespace cmpg

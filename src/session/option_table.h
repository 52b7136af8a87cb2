// The table of all options: names, help, defaults and fields. Parsing, run.json, help and the identity of a run all read it.
#pragma once

#include "session/options.h"

#include <span>

namespace cmpg {

enum class OptionRole {
    Result,   // bears on the result: in run.json, and part of what makes two runs the same
    Contents, // in run.json; the identity has the contents of what it names instead
    Run,      // in run.json; bears on no result
    Output    // neither
};

struct OptionSpec {
    const char* key;          // the name without its dashes
    const char* value = "";   // kind of its value, for the help
    const char* initial = ""; // default, for the help
    const char* help = "";
    OptionRole role = OptionRole::Result;
};

// How a text becomes a number, beside plain numbers.
enum class Unit { Share, Seconds };

enum class OptionGroup {
    Sampling, Guide, Scene, Running, // common to all commands
    Budget, Batches, Parameters, Target, Comparison, Measurement, Differentiation, Check, Optimizer, RunFolder, Layers, View, GuideFile
};

// In the order of run.json. Common ones are left out.
std::span<const OptionGroup> groupsOf(Command command);
// What run.json has of a command: common ones included where they apply.
std::vector<OptionGroup> recordedGroups(Command command);
inline constexpr OptionGroup kCommonGroups[] = {OptionGroup::Sampling, OptionGroup::Guide, OptionGroup::Scene, OptionGroup::Running};
inline constexpr OptionGroup kLastGroup = OptionGroup::GuideFile;

// Calls v(spec, field) for every option of a group; enumerations come with the names of their values, numbers with units with the unit.
template <class O, class V> void visitGroup(OptionGroup group, O& o, V&& v) {
    using enum OptionRole;
    switch (group) {
    case OptionGroup::Sampling:
        v({"quality", "", "balanced", "Defaults that trade error for time: a quarter of the samples and half the depth; or four times the samples and twice the depth", Run},
          o.quality, kQualities);
        v({"spp", "N", "64; optimize, compare, tradeoff, --check, a step in a window: 16", "Samples per pixel of an image"}, o.spp);
        v({"spp-gradient", "N", "as --spp; optimize, also in compare, and tradeoff: 4", "Samples per pixel of a derivative pass"}, o.sppGradient);
        v({"seed", "N", "0", "Seed of all random numbers"}, o.seed);
        v({"sampler", "", "sobol", "Random numbers: Owen-scrambled Sobol points, or independent ones"}, o.sampler, kSamplers);
        v({"sampling", "", "auto",
           "How directions are drawn: from the materials alone; guided by light, by its derivatives, by both half and half, by both weighted "
           "by the path so far; or what training finds best"},
          o.sampling, kSamplings);
        v({"no-nee", "", "", "No light sampling: emitters are only found by chance, punctual lights never"}, o.noLightSampling);
        v({"pixel-sampling", "", "adjoint", "Reverse mode: the same samples everywhere, or more where the adjoint is large"}, o.pixelSampling, kPixelSamplings);
        v({"positivize", "", "", "Derivative passes in two halves, one for each sign of the derivative"}, o.positivize);
        v({"roulette", "", "adjoint",
           "Reverse mode: end and split paths by what the guide expects of them, where it pays; off: end them by what surfaces scatter alone, as in images"},
          o.roulette, kRoulettes);
        break;
    case OptionGroup::Guide:
        v({"train", "N", "0; compare, tradeoff: 8", "Learning passes before the measured one", Run}, o.train);
        v({"train-spp", "N", "all together as many as the measured pass, but 4 each; of several batches: 8", "Samples per pixel of a learning pass"}, o.trainSpp);
        v({"save-guide", "FILE", "", "Write what was learned", Run}, o.saveGuide);
        v({"load-guide", "FILE", "", "Start from what an earlier run learned", Contents}, o.loadGuide);
        v({"guide-memory", "MiB", "64", "Limit of the guide's own device memory; cells stop splitting there"}, o.guideMemory);
        v({"guide-share", "F", "0.5", "Of directions, drawn from the guide where it knows something; the rest from the material"}, o.guideShare);
        v({"cell-records", "N", "6000", "Records of a pass from which a cell of the guide splits"}, o.cellRecords);
        v({"direction-share", "F", "0.03", "Share of a cell's light or derivatives from which a quadrant of directions splits"}, o.directionShare);
        v({"forgetting", "F", "0.9", "What the guide keeps of what it learned before parameters changed, each time"}, o.forgetting);
        v({"roulette-effort", "F", "0.3", "A path whose expected contribution is this share of the average continues once: less makes more copies"}, o.rouletteEffort);
        break;
    case OptionGroup::Scene:
        v({"width", "N", "as the target, adjoint or Mitsuba film, else 512; --check: 128; compare, tradeoff: 256", "Width of the image in pixels. Batch commands average larger targets", Contents}, o.width);
        v({"height", "N", "from the camera's aspect ratio", "Height of the image in pixels", Contents}, o.height);
        v({"camera", "NAME", "the first", "Camera of the scene", Contents}, o.camera);
        v({"max-depth", "N", "the scene's, else 8", "Segments of a path; 1 = only lights seen directly"}, o.maxDepth);
        v({"texture", "P=WxH", "",
           "Give a parameter a texture of this size, before --set: a constant becomes one, a texture is resampled. P may be a glob. Repeats", Contents}, o.texture);
        v({"set", "P=VALUE|FILE", "", "Give a parameter a value: P=0.5, P=r,g,b (fills every entry) or P=FILE (of its own size). P may be a glob. Repeats", Contents}, o.set);
        v({"environment", "FILE", "", "Latitude-longitude picture of the surroundings, in place of the scene's own, or of none", Contents}, o.environment);
        v({"environment-rotation", "DEGREES", "0", "Turn that picture about +Y, counter-clockwise seen from above", Contents}, o.environmentRotation);
        v({"filter", "box|tent|gaussian", "the scene's, else box",
           "How a pixel weighs what is around its middle, as targets of other renderers do: tent:R has a radius, gaussian:S a standard deviation in pixels; "
           "without, 1 and 0.5", Contents},
          o.filter);
        v({"define", "NAME=VALUE", "", "Value of a variable of a Mitsuba scene, in place of its default. Repeats", Contents}, o.define);
        break;
    case OptionGroup::Running:
        v({"device", "DEVICE", "the best", "Number or part of the name of a device of --list-devices", Run}, o.device);
        v({"memory", "MiB", "1024", "Budget of transient device memory; results do not depend on it", Run}, o.memory);
        v({"all-features", "", "", "Kernels and buffers for all features, needed or not: the same results, slower; for comparison", Output}, o.allFeatures);
        v({"kernel-times", "", "", "Measure how long each kernel runs, for --json; on a CPU passes take about a tenth longer for it", Output}, o.kernelTimes);
        v({"output", "PATH", "", "File or folder to write", Output}, o.output);
        v({"config", "FILE", "", "Start from the options of a run.json", Output}, o.config);
        v({"display-server", "HOST:PORT", "none",
           "render, gradient, optimize: show images while they are made in a display such as tev, over the network. A slow or absent "
           "display does not hold up the run", Output},
          o.displayServer);
        v({"json", "", "", "Print one JSON object on stdout, everything else on stderr", Output}, o.json);
        v({"quiet", "", "", "Print no configuration and no progress", Output}, o.quiet);
        v({"headless", "", "", "No window: needs one of the commands, none of which opens one", Output}, o.headless);
        break;
    case OptionGroup::Budget:
        v({"error-target", "E%", "",
           "Sample until |standard error| / |estimate| is this small, over all pixels or texels; optimize: of the gradient of each step. Exit "
           "code 1 if it is not within the samples (--spp, or --spp-gradient) or the time allowed"},
          o.errorTarget, Unit::Share);
        v({"time-budget", "T", "", "Sample for so long, loading and learning included; optimize: steps", Run}, o.timeBudget, Unit::Seconds);
        break;
    case OptionGroup::Batches:
        v({"batches", "N", "8 with an error target or a time budget, else none",
           "Divide the samples among so many batches with random numbers of their own, whose spread tells the error"},
          o.batches);
        break;
    case OptionGroup::Parameters:
        v({"param", "P", "", "Parameter, as 'inspect' prints it, or a glob. Repeats", Contents}, o.param);
        break;
    case OptionGroup::Target:
        v({"target", "[CAMERA=]FILE", "", "Image the loss compares with: .exr .hdr .png .jpg. Of one camera by CAMERA=FILE; repeats in optimize", Contents}, o.target);
        v({"loss", "", "mse", "Mean over pixels and channels"}, o.loss, kLosses);
        v({"mask", "[CAMERA=]FILE", "", "Image whose mean channel weights the pixels of the loss, of all targets or of one camera's. Repeats", Contents}, o.mask);
        v({"target-exposure", "E", "0", "Multiply targets by 2^E", Contents}, o.targetExposure);
        break;
    case OptionGroup::Comparison:
        v({"methods", "LIST", "plain,primal,conditional,ours",
           "Comma-separated: plain, primal, differential, uniform, conditional, ours; each with parts, as in "
           "conditional+pixels+roulette: pixels, roulette, positivize, nonee, independent"},
          o.methods);
        v({"mode", "LIST", "reverse",
           "Comma-separated: the derivative image (forward), the gradient of an adjoint or a target's loss (reverse), a whole "
           "recovery from a target (optimize)"},
          o.mode);
        v({"time", "T", "", "Equal time: of passes or steps for each method. Without it, equal samples"}, o.time, Unit::Seconds);
        v({"seeds", "K", "16; under --time: 4; optimize: 1", "Passes of each method, or the fewest under --time; optimize: repetitions"}, o.seeds);
        v({"reference", "auto|FILE", "auto",
           "What is right: made by the most efficient method (auto), or an image. optimize: the scene's own values, or an image"},
          o.reference);
        v({"reference-time", "T", "twice all measured passes", "Most time for an automatic reference"}, o.referenceTime, Unit::Seconds);
        v({"adjoint-spp", "N", "256", "Samples per pixel of the image whose loss gives the adjoint of --target"}, o.adjointSpp);
        break;
    case OptionGroup::Measurement:
        v({"time", "T", "30min", "Of the whole measurement, about"}, o.time, Unit::Seconds);
        v({"seeds", "K", "3", "Trainings of each setting, with random numbers of their own"}, o.seeds);
        break;
    case OptionGroup::Differentiation:
        v({"direction", "one|self|FILE", "one", "Forward mode: image derivative when every entry grows alike (one), in proportion to its value (self), or along an image"},
          o.direction);
        v({"adjoint", "FILE.exr", "", "Reverse mode: adjoint^T . dI/dP for this image, in P's own shape"}, o.adjoint);
        break;
    case OptionGroup::Check:
        v({"check", "", "", "Compare the forward gradient with finite differences; exit code 1 if they disagree"}, o.check);
        break;
    case OptionGroup::Optimizer:
        v({"steps", "N", "200", "Steps"}, o.recovery.steps);
        v({"optimizer", "", "auto", "Update rule; auto: gauss-newton where the loss is a squared one, but for textures of the sheen's colour, else adam"},
          o.recovery.optimizer, kOptimizers);
        v({"rate", "[SLOT=]RATE", "adam 0.02, normal 0.01; sgd 0.5, normal 0.25", "Learning rate, of all parameters or of one slot (baseColor, roughness ...). Repeats"},
          o.rate);
        v({"schedule", "", "constant", "How the rate falls"}, o.recovery.schedule, kSchedules);
        v({"final-rate", "F", "0.1", "Factor of the rate at the last step, under a schedule"}, o.recovery.finalRate);
        v({"total-variation", "W", "0", "Weight of the total variation of textures in the loss"}, o.recovery.totalVariation);
        v({"prior", "B", "8",
           "How alike neighbouring texels are, light in units of its mean, before any image is seen: differences are as likely as exp(-B n (d^3/4)^(1/4)), "
           "with n channels and d the root mean square of theirs, beside images trusted to 10 % of their mean; 0: no prior"},
          o.recovery.prior);
        v({"spp-difference", "N", "12",
           "Samples per pixel, at most, by which a step brings the image of the step before up to date; 0: every step renders its own of --spp"},
          o.recovery.sppDifference);
        v({"views-per-step", "N", "0",
           "Of several targets at most so many a step, in random order, each once before any again; 0: all, but where Gauss-Newton recovers textures and no "
           "constants of four and more at first one, and of fewer one by maps of roughness and other shapes of lobes alone"},
          o.recovery.viewsPerStep);
        v({"warm-up", "N", "0", "First steps, which learn the guide and leave the parameters alone"}, o.recovery.warmUp);
        v({"freeze", "N", "never", "Step from which on the guide stays as it is"}, o.freeze);
        v({"stop-after", "N", "--steps", "End after so many of the steps, with the schedule of all", Run}, o.stopAfter);
        break;
    case OptionGroup::RunFolder:
        v({"spp-pictures", "N", "4 x --spp, at least 64; of more than four views those of four shared, at least 8",
           "Samples per pixel of the images that are made after the last step, whose time is in no --time-budget; after a short one as many as should fit into "
           "a tenth of it, at least 16 (of many views 8; of images larger than 128 x 128 as much fewer, 2 at least)",
           Run},
          o.sppPictures);
        v({"checkpoint-every", "N|T", "10m", "Keep all that a later run needs to continue, after so many steps, or so much time (s, m or h); 0: never", Run},
          o.checkpointEvery);
        v({"resume", "FOLDER", "",
           "Continue the run of a folder, from its last checkpoint or from the beginning. The scene and all options may be left away; "
           "what is given must agree with the run", Output},
          o.resume);
        break;
    case OptionGroup::Layers:
        v({"layers", "FILE.exr", "", "What the camera sees first, and what the guide does there, as layers of this file; not in reverse mode", Output}, o.layers);
        break;
    case OptionGroup::View:
        v({"signed", "", "", "Signed data: blue below zero, orange above, with the scale"}, o.isSigned);
        v({"exposure", "E", "0", "Multiply by 2^E"}, o.exposure);
        v({"scale", "S", "99.5th percentile of |value|", "Signed: the value of the deepest colour"}, o.scale);
        v({"layer", "NAME", "", "Layer of an EXR file with several, such as --layers writes"}, o.layer);
        break;
    case OptionGroup::GuideFile:
        v({"validate", "", "", "Check all that must hold; exit code 1 if something does not"}, o.validateGuide);
        v({"csv", "", "", "Print one line per cell instead"}, o.csv);
        v({"cell", "N", "the one with most records", "Cell to draw"}, o.cell);
        v({"weights", "L,D", "1,1", "Weights of light and of its derivatives in the mixture that is drawn"}, o.weights);
        break;
    }
}

} // namespace cmpg
